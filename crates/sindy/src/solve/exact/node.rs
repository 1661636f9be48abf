//! One node of the tree: the triangular factor of the free terms, after the fixed ones are projected out.

/// `G = L Lᵀ`, `b = L z` of the free terms, and the share of the residual with all of them in.
#[derive(Clone, Default)]
pub(super) struct Node {
    /// Rows of `L`, `stride` apart.
    l: Vec<f64>,
    stride: usize,
    pub(super) z: Vec<f64>,
    /// The free terms, in the order of the rows.
    pub(super) free: Vec<usize>,
    /// The fixed terms.
    pub(super) fixed: u128,
    /// Their number.
    pub(super) k: usize,
    /// Residual share of fixed and free terms together.
    pub(super) residual: f64,
    /// What each free term's removal costs alone.
    pub(super) cost: Vec<f64>,
    /// For each position, a bound on the largest eigenvalue of the correlation of the estimates from
    /// that position on.
    pub(super) spread: Vec<f64>,
    inverse: Vec<f64>,
}

impl Node {
    /// Room for `m` terms.
    pub(super) fn new(m: usize) -> Self {
        Self {
            l: vec![0.0; m * m],
            stride: m,
            inverse: vec![0.0; m * m],
            ..Self::default()
        }
    }

    /// Starts from the rows of a factor over all terms.
    pub(super) fn root(m: usize, l: impl Fn(usize, usize) -> f64, z: Vec<f64>) -> Self {
        let mut node = Self::new(m);
        for i in 0..m {
            (0..=i).for_each(|c| node.l[i * m + c] = l(i, c));
        }
        node.residual = 1.0 - z.iter().map(|v| v * v).sum::<f64>();
        node.z = z;
        node.free = (0..m).collect();
        node
    }

    /// Becomes the child of `parent` that drops its free term `i` and fixes those before it.
    pub(super) fn child_of(&mut self, parent: &Self, i: usize) {
        let n = parent.free.len() - i - 1;
        let s = self.stride;
        self.free.clear();
        self.free.extend_from_slice(&parent.free[i + 1..]);
        self.fixed = parent.free[..i]
            .iter()
            .fold(parent.fixed, |m, &j| m | 1 << j);
        self.k = parent.k + i;
        self.z.clear();
        self.z.extend_from_slice(&parent.z[i..]);
        for r in 0..n {
            let from = (i + 1 + r) * s + i;
            self.l[r * s..r * s + r + 2].copy_from_slice(&parent.l[from..from + r + 2]);
        }
        // Row r holds r + 2 entries: rotate columns r and r + 1 until the last is gone.
        for r in 0..n {
            self.rotate(r, r + 1, r, n);
        }
        let lost = self.z.pop().unwrap_or(0.0);
        self.residual = parent.residual + lost * lost;
    }

    /// Rotates columns `a` and `b` so that entry (`row`, `b`) vanishes; rows up to `rows` follow.
    fn rotate(&mut self, a: usize, b: usize, row: usize, rows: usize) {
        let s = self.stride;
        let (u, v) = (self.l[row * s + a], self.l[row * s + b]);
        if v == 0.0 {
            return;
        }
        let h = u.hypot(v);
        let (c, d) = (u / h, v / h);
        for r in row..rows {
            let (x, y) = (self.l[r * s + a], self.l[r * s + b]);
            self.l[r * s + a] = c * x + d * y;
            self.l[r * s + b] = c * y - d * x;
        }
        self.l[row * s + b] = 0.0;
        let (x, y) = (self.z[a], self.z[b]);
        self.z[a] = c * x + d * y;
        self.z[b] = c * y - d * x;
    }

    /// Sorts the free terms, the costliest first, and bounds what several removals cost together.
    pub(super) fn prepare(&mut self) {
        self.invert();
        let n = self.free.len();
        let s = self.stride;
        self.cost.clear();
        let mut norm = vec![0.0; n];
        for j in 0..n {
            let mut x = 0.0;
            for i in j..n {
                let m = self.inverse[i * s + j];
                norm[j] += m * m;
                x += m * self.z[i];
            }
            self.cost.push(x * x / norm[j]);
        }
        let mut order: Vec<usize> = (0..n).collect();
        order.sort_by(|&a, &b| self.cost[b].total_cmp(&self.cost[a]).then(a.cmp(&b)));
        // Correlation of estimates i and j: the columns i and j of L⁻¹. Row sums bound the eigenvalue, and so
        // does the root of the sum of squares.
        self.spread.clear();
        self.spread.resize(n, 1.0);
        let mut sums = vec![1.0; n];
        let mut squares = 0.0;
        for a in (0..n).rev() {
            let i = order[a];
            squares += 1.0;
            for q in a + 1..n {
                let j = order[q];
                let dot: f64 = (i.max(j)..n)
                    .map(|r| self.inverse[r * s + i] * self.inverse[r * s + j])
                    .sum();
                let rho = (dot / (norm[i] * norm[j]).sqrt()).abs();
                sums[a] += rho;
                sums[q] += rho;
                squares += 2.0 * rho * rho;
            }
            let rows = sums[a..].iter().copied().fold(1.0, f64::max);
            self.spread[a] = rows.min(f64::sqrt(squares));
        }
        if order.windows(2).any(|w| w[0] > w[1]) {
            self.permute(&order);
        }
    }

    /// `L⁻¹`.
    fn invert(&mut self) {
        let (n, s) = (self.free.len(), self.stride);
        for j in 0..n {
            for i in j..n {
                let dot: f64 = (j..i)
                    .map(|c| self.l[i * s + c] * self.inverse[c * s + j])
                    .sum();
                self.inverse[i * s + j] =
                    (if i == j { 1.0 } else { 0.0 } - dot) / self.l[i * s + i];
            }
        }
    }

    /// Puts the rows into another order and makes the factor triangular again.
    fn permute(&mut self, order: &[usize]) {
        let (n, s) = (order.len(), self.stride);
        for (r, &from) in order.iter().enumerate() {
            for c in 0..n {
                self.inverse[r * s + c] = if c <= from { self.l[from * s + c] } else { 0.0 };
            }
        }
        std::mem::swap(&mut self.l, &mut self.inverse);
        self.free = order.iter().map(|&i| self.free[i]).collect();
        self.cost = order.iter().map(|&i| self.cost[i]).collect();
        for r in 0..n {
            // From the right, so that entries that are zero already cost nothing.
            for c in (r + 1..n).rev() {
                self.rotate(r, c, r, n);
            }
        }
    }
}
