//! Systems with known equations. None of them was used to choose a setting.

mod damping;
mod diffusions;
mod hybrid;
mod maps;
mod positions;
mod stiff;

pub(crate) use damping::*;
pub(crate) use diffusions::*;
pub(crate) use hybrid::*;
pub(crate) use maps::*;
pub(crate) use positions::*;
pub(crate) use stiff::*;

/// The terms of each equation with their coefficients.
pub(crate) type Equations = &'static [&'static [(&'static str, f64)]];

/// Where candidate terms come from.
#[derive(Clone, Copy)]
pub(crate) enum Candidates {
    /// All monomials of states and inputs up to a degree.
    Degree(u32),
    Terms(&'static [&'static str]),
}

/// When rows are taken.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Clock {
    /// Each row this long after the one before.
    Every(f64),
    /// From the first time to the second, evenly in the logarithm, after a row at 0.
    Logarithmic(f64, f64),
    /// A map: one row for each iteration.
    Map,
}

/// What is measured and looked for.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Task {
    /// All states are measured.
    States,
    /// The first half of the states, positions. The other half are their velocities, and `x' = x_dot` is known.
    Positions,
    /// All states are measured; their equations switch.
    Hybrid,
    /// All states are measured. They are driven by noise with these squared diffusions, which are looked for too.
    Diffusion(Equations),
    /// The same, but nothing says that they are driven by noise.
    Disturbed(Equations),
}

/// A system, its library and its trajectories.
#[derive(Clone, Copy)]
pub(crate) struct System {
    pub(crate) name: &'static str,
    pub(crate) states: &'static [&'static str],
    pub(crate) inputs: &'static [&'static str],
    pub(crate) truth: Equations,
    pub(crate) candidates: Candidates,
    /// Start and formulas of the inputs, for each trajectory.
    pub(crate) runs: &'static [(&'static [f64], &'static [&'static str])],
    pub(crate) clock: Clock,
    pub(crate) rows: usize,
    /// Steps of the integrator between rows, at least, and the longest that it may take.
    pub(crate) substeps: usize,
    pub(crate) longest: f64,
    /// Inputs keep the value of a row until the next.
    pub(crate) held: bool,
    pub(crate) task: Task,
}

impl System {
    /// The states that are measured, the first ones.
    pub(crate) fn measured(&self) -> &'static [&'static str] {
        match self.task {
            Task::States | Task::Hybrid | Task::Diffusion(_) | Task::Disturbed(_) => self.states,
            Task::Positions => &self.states[..self.states.len() / 2],
        }
    }

    /// The first equation that is scored: those before it are known.
    pub(crate) fn scored(&self) -> usize {
        match self.task {
            Task::States | Task::Hybrid | Task::Diffusion(_) | Task::Disturbed(_) => 0,
            Task::Positions => self.states.len() / 2,
        }
    }
}

/// What most systems here share.
pub(crate) const PLAIN: System = System {
    name: "",
    states: &["x", "y"],
    inputs: &[],
    truth: &[],
    candidates: Candidates::Degree(3),
    runs: &[],
    clock: Clock::Every(0.05),
    rows: 800,
    substeps: 20,
    longest: f64::INFINITY,
    held: false,
    task: Task::States,
};

pub(crate) const BRUSSELATOR: System = System {
    name: "Brusselator",
    truth: &[
        &[("1", 1.0), ("x", -4.0), ("x^2*y", 1.0)],
        &[("x", 3.0), ("x^2*y", -1.0)],
    ],
    runs: &[(&[1.2, 2.8], &[]), (&[2.5, 1.0], &[])],
    ..PLAIN
};

pub(crate) const LOTKA_VOLTERRA: System = System {
    name: "Lotka-Volterra",
    truth: &[&[("x", 1.1), ("x*y", -0.4)], &[("y", -0.4), ("x*y", 0.1)]],
    runs: &[(&[10.0, 5.0], &[]), (&[6.0, 2.0], &[])],
    ..PLAIN
};

const PENDULUM_TERMS: &[&str] = &[
    "1", "q", "v", "q^2", "q*v", "v^2", "q^3", "v^3", "sin(q)", "cos(q)", "v*sin(q)", "v*cos(q)",
];

pub(crate) const PENDULUM: System = System {
    name: "pendulum",
    states: &["q", "v"],
    truth: &[&[("v", 1.0)], &[("v", -0.15), ("sin(q)", -4.0)]],
    candidates: Candidates::Terms(PENDULUM_TERMS),
    runs: &[(&[2.5, 0.0], &[]), (&[-1.2, 3.0], &[])],
    clock: Clock::Every(0.03),
    ..PLAIN
};

pub(crate) const LORENZ: System = System {
    name: "Lorenz",
    states: &["x", "y", "z"],
    truth: &[
        &[("x", -10.0), ("y", 10.0)],
        &[("x", 28.0), ("y", -1.0), ("x*z", -1.0)],
        &[("z", -8.0 / 3.0), ("x*y", 1.0)],
    ],
    runs: &[(&[5.0, -3.0, 20.0], &[])],
    clock: Clock::Every(0.01),
    rows: 1500,
    ..PLAIN
};

pub(crate) const VAN_DER_POL: System = System {
    name: "Van der Pol",
    truth: &[&[("y", 1.0)], &[("x", -1.0), ("y", 1.5), ("x^2*y", -1.5)]],
    runs: &[(&[0.3, 0.1], &[]), (&[3.0, -2.0], &[])],
    clock: Clock::Every(0.04),
    ..PLAIN
};

/// Two wells with friction.
pub(crate) const DUFFING: System = System {
    name: "Duffing",
    truth: &[&[("y", 1.0)], &[("x", 1.0), ("y", -0.2), ("x^3", -1.0)]],
    runs: &[(&[2.0, 0.0], &[]), (&[-0.2, 1.5], &[])],
    ..PLAIN
};

pub(crate) const FORCED_DUFFING: System = System {
    name: "forced Duffing",
    inputs: &["u"],
    truth: &[
        &[("y", 1.0)],
        &[("x", 1.0), ("y", -0.3), ("x^3", -1.0), ("u", 1.0)],
    ],
    runs: &[
        (&[0.5, 0.0], &["0.5*cos(1.2*t)"]),
        (&[-1.0, 0.3], &["0.4*cos(0.8*t) + 0.2*sin(2*t)"]),
    ],
    ..PLAIN
};

pub(crate) const FITZHUGH_NAGUMO: System = System {
    name: "FitzHugh-Nagumo",
    states: &["v", "w"],
    truth: &[
        &[("1", 0.5), ("v", 1.0), ("v^3", -1.0 / 3.0), ("w", -1.0)],
        &[("1", 0.056), ("v", 0.08), ("w", -0.064)],
    ],
    runs: &[(&[-1.0, 1.0], &[]), (&[1.5, -0.5], &[])],
    clock: Clock::Every(0.15),
    ..PLAIN
};

/// Susceptible and infected shares of a population, four outbreaks.
pub(crate) const SIR: System = System {
    name: "SIR",
    states: &["s", "i"],
    truth: &[&[("s*i", -1.2)], &[("s*i", 1.2), ("i", -0.3)]],
    runs: &[
        (&[0.99, 0.01], &[]),
        (&[0.7, 0.05], &[]),
        (&[0.5, 0.4], &[]),
        (&[0.9, 0.1], &[]),
    ],
    clock: Clock::Every(0.15),
    rows: 200,
    ..PLAIN
};

pub(crate) const ROSSLER: System = System {
    name: "Rossler",
    states: &["x", "y", "z"],
    truth: &[
        &[("y", -1.0), ("z", -1.0)],
        &[("x", 1.0), ("y", 0.2)],
        &[("1", 0.2), ("z", -5.7), ("x*z", 1.0)],
    ],
    candidates: Candidates::Degree(2),
    runs: &[(&[1.0, -4.0, 0.5], &[])],
    rows: 2000,
    ..PLAIN
};

pub(crate) const LORENZ_96: System = System {
    name: "Lorenz-96",
    states: &["a", "b", "c", "d", "e"],
    truth: &[
        &[("1", 8.0), ("a", -1.0), ("b*e", 1.0), ("d*e", -1.0)],
        &[("1", 8.0), ("b", -1.0), ("a*c", 1.0), ("a*e", -1.0)],
        &[("1", 8.0), ("c", -1.0), ("b*d", 1.0), ("a*b", -1.0)],
        &[("1", 8.0), ("d", -1.0), ("c*e", 1.0), ("b*c", -1.0)],
        &[("1", 8.0), ("e", -1.0), ("a*d", 1.0), ("c*d", -1.0)],
    ],
    candidates: Candidates::Degree(2),
    runs: &[(&[1.0, 6.0, -2.0, 3.0, 0.5], &[])],
    clock: Clock::Every(0.02),
    rows: 1000,
    ..PLAIN
};

pub(crate) const CHUA: System = System {
    name: "Chua, cubic",
    states: &["x", "y", "z"],
    truth: &[
        &[("x", 10.0 / 7.0), ("x^3", -20.0 / 7.0), ("y", 10.0)],
        &[("x", 1.0), ("y", -1.0), ("z", 1.0)],
        &[("y", -100.0 / 7.0)],
    ],
    runs: &[(&[0.7, 0.1, -0.5], &[])],
    clock: Clock::Every(0.02),
    rows: 2000,
    ..PLAIN
};

pub(crate) const DOUBLE_WELL: System = System {
    name: "double well",
    states: &["x"],
    truth: &[&[("x", 1.0), ("x^3", -1.0)]],
    candidates: Candidates::Degree(5),
    runs: &[(&[0.1], &[]), (&[-0.1], &[]), (&[2.0], &[]), (&[-1.8], &[])],
    clock: Clock::Every(0.02),
    rows: 1000,
    ..PLAIN
};

pub(crate) const RIGID_BODY: System = System {
    name: "rigid body",
    states: &["p", "q", "r"],
    truth: &[&[("q*r", -0.5)], &[("p*r", 0.8)], &[("p*q", -0.4)]],
    candidates: Candidates::Degree(2),
    runs: &[(&[2.0, 0.1, 1.0], &[]), (&[0.3, 2.0, -0.5], &[])],
    rows: 400,
    ..PLAIN
};

pub(crate) const SELKOV: System = System {
    name: "Selkov",
    truth: &[
        &[("x", -1.0), ("y", 0.08), ("x^2*y", 1.0)],
        &[("1", 0.6), ("y", -0.08), ("x^2*y", -1.0)],
    ],
    runs: &[(&[0.8, 1.2], &[]), (&[1.5, 0.4], &[])],
    ..PLAIN
};

/// A predator that is sated: no polynomial.
pub(crate) const HOLLING: System = System {
    name: "Holling",
    truth: &[
        &[("x", 1.0), ("x^2", -0.125), ("x*y/(1 + x)", -2.0)],
        &[("y", -0.5), ("x*y/(1 + x)", 0.8)],
    ],
    runs: &[(&[3.0, 1.0], &[]), (&[1.0, 2.5], &[])],
    clock: Clock::Every(0.1),
    ..PLAIN
};

/// A lag of first order with saturation, switched by a command that is held.
pub(crate) const SWITCHED: System = System {
    name: "switched lag",
    states: &["x"],
    inputs: &["u"],
    truth: &[&[("x", -1.5), ("u", 1.5), ("x^3", -0.4)]],
    runs: &[
        (&[0.0], &["floor(2*sin(0.9*t) + 1.3*sin(2.3*t))"]),
        (&[1.0], &["floor(1.5*sin(1.7*t) + sin(0.6*t))"]),
    ],
    held: true,
    ..PLAIN
};

/// The published force over a moving platform, equation (12) of the paper, smooth inputs.
pub(crate) const GROUND_EFFECT: System = System {
    name: "equation (12)",
    states: &["f"],
    inputs: &["s", "z", "v_p", "v_q"],
    truth: &[&[
        ("1", 0.804),
        ("f", -0.088),
        ("s", -3.912),
        ("z", 0.586),
        ("v_p", 1.051),
        ("v_q", -1.049),
        ("s^2", 4.854),
        ("v_p*v_q", 1.103),
        ("z^2", -2.504),
        ("v_p^2", -0.535),
        ("v_q^2", -0.562),
    ]],
    candidates: Candidates::Terms(&[
        "1", "f", "s", "z", "v_p", "v_q", "s^2", "v_p*v_q", "z^2", "v_p^2", "v_q^2",
    ]),
    runs: &[
        (
            &[0.4],
            &[
                "0.45 + 0.08*sin(0.8*t) + 0.04*sin(2.4*t)",
                "0.35 + 0.1*sin(t) + 0.05*sin(2*t) - 0.05*sin(1.7*t)",
                "0.085*cos(1.7*t)",
                "0.1*cos(t) + 0.1*cos(2*t)",
            ],
        ),
        (
            &[0.7],
            &[
                "0.48 + 0.07*sin(1.1*t + 1) + 0.05*sin(2.7*t)",
                "0.35 + 0.12*sin(1.3*t) + 0.04*sin(2.5*t) - 0.07*sin(2.1*t + 1)",
                "0.147*cos(2.1*t + 1)",
                "0.156*cos(1.3*t) + 0.1*cos(2.5*t)",
            ],
        ),
        (
            &[0.2],
            &[
                "0.5 + 0.09*sin(0.6*t + 2) + 0.03*sin(3.1*t)",
                "0.35 + 0.11*sin(0.7*t + 1) + 0.06*sin(1.6*t) - 0.06*sin(2.6*t)",
                "0.156*cos(2.6*t)",
                "0.077*cos(0.7*t + 1) + 0.096*cos(1.6*t)",
            ],
        ),
    ],
    clock: Clock::Every(0.01),
    rows: 3000,
    substeps: 4,
    ..PLAIN
};
