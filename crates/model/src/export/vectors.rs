//! Recorded vectors: inputs, and what `touchdown-flight` computes from them, as a test in C.

use touchdown_flight::ground_effect::{GroundEffect as _, GroundEffectInput, Guarded};
use touchdown_flight::real::r;
use touchdown_flight::thrust::{ThrustModel, ThrustState};

use super::Number;
use super::flying::FlyingModel;

/// Number of recorded steps: two random walks over the range of each input.
const STEPS: usize = 400;
/// Every so many steps one input is not a number, or a step has another length.
const FAULT_EVERY: usize = 23;

/// A fixed sequence of pseudo-random numbers in [0, 1) (Knuth's MMIX generator), the same on
/// every machine and for ever, so that an export has the same bytes.
pub(super) struct Sequence(u64);

impl Sequence {
    pub(super) fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub(super) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        // The 53 leading bits are exact in a double.
        #[allow(clippy::cast_precision_loss)]
        let share = (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        share
    }

    /// A number in a range that is wider than [low, high] by a tenth on both sides.
    fn around<R: Number>(&mut self, low: f64, high: f64) -> R {
        r(low + (1.2 * self.next() - 0.1) * (high - low))
    }
}

/// Length of a step: 10 ms, sometimes another one, or none.
pub(super) fn dt<R: Number>(step: usize) -> R {
    match step % (7 * FAULT_EVERY) {
        11 => r(0.05),
        40 => R::ZERO,
        70 => r(f64::NAN),
        90 => r(-0.01),
        120 => r(0.6),
        _ => r(0.01),
    }
}

/// The program that replays the vectors.
pub(super) fn test_program<R: Number>(model: &FlyingModel<R>, name: &str) -> String {
    let (rows, body) = match model {
        FlyingModel::Thrust(model) => (thrust(model), THRUST_BODY),
        FlyingModel::GroundEffect(model) => (ground_effect(model), GROUND_BODY),
    };
    test_of(&rows, body, name)
}

/// The program that replays rows, given its loop over them.
pub(super) fn test_of<R: Number>(rows: &[Vec<R>], body: &str, name: &str) -> String {
    let word = if R::TYPES[0] == "float" {
        "uint32_t"
    } else {
        "uint64_t"
    };
    let columns = rows.first().map_or(0, Vec::len);
    let mut table = String::new();
    for row in rows {
        let words: Vec<_> = row.iter().map(|x| format!("0x{:x}u", x.bits())).collect();
        table.push_str(&format!("    {{{}}},\n", words.join(", ")));
    }
    TEST.replace("@BODY@", body)
        .replace("@ROWS@", &rows.len().to_string())
        .replace("@COLUMNS@", &columns.to_string())
        .replace("@TABLE@", table.trim_end())
        .replace("WORD", word)
        .replace("REAL", R::TYPES[0])
        .replace("NAME", name)
}

/// Rows of throttle, dt, thrust, thrust asked for, its throttle.
fn thrust<R: Number>(model: &ThrustModel<R>) -> Vec<Vec<R>> {
    let mut sequence = Sequence::new(1);
    let mut state = ThrustState {
        x: model.rest(r(0.5)),
    };
    (0..STEPS)
        .map(|step| {
            let mut throttle: R = sequence.around(0.0, 1.0);
            if step % FAULT_EVERY == 5 {
                throttle = r(f64::NAN);
            }
            let dt = dt(step);
            model.step(&mut state, throttle, dt);
            let asked: R = sequence.around(0.0, 25.0);
            let found = model.throttle_for(asked);
            vec![throttle, dt, state.thrust_n(), asked, found]
        })
        .collect()
}

/// Rows of the input, dt, ratio and force.
fn ground_effect<R: Number>(model: &Guarded<R>) -> Vec<Vec<R>> {
    let mut sequence = Sequence::new(2);
    let top = 2.5 * model.validity.height_max_m.to_f64();
    let mut input = GroundEffectInput {
        thrust_n: r(13.4),
        throttle: r(0.5),
        height_m: model.validity.height_max_m,
        ..GroundEffectInput::default()
    };
    let mut state = model.rest(&input);
    (0..STEPS)
        .map(|step| {
            input.thrust_n = sequence.around(0.0, 20.0);
            input.throttle = sequence.around(0.0, 1.0);
            input.height_m = sequence.around(0.0, top);
            input.vehicle_velocity_mps = sequence.around(-1.0, 1.0);
            input.deck_velocity_mps = sequence.around(-1.0, 1.0);
            match step % FAULT_EVERY {
                5 => input.height_m = r(f64::NAN),
                9 => input.thrust_n = r(f64::INFINITY),
                14 => input.deck_velocity_mps = r(f64::NAN),
                _ => {}
            }
            let dt = dt(step);
            let lift = model.step(&mut state, &input, dt);
            vec![
                input.thrust_n,
                input.throttle,
                input.height_m,
                input.vehicle_velocity_mps,
                input.deck_velocity_mps,
                dt,
                lift.ratio,
                lift.force_n,
            ]
        })
        .collect()
}

const THRUST_BODY: &str = "\
    NAME_init(&state, (REAL)0.5);
    for (i = 0; i < ROWS; i++) {
        const WORD *row = VECTORS[i];
        compare(i, NAME_step(&state, real_of(row[0]), real_of(row[1])), row[2]);
        compare(i, NAME_throttle_for(real_of(row[3])), row[4]);
    }
";

const GROUND_BODY: &str = "\
    NAME_input start = {(REAL)13.4, (REAL)0.5, (REAL)0.0, (REAL)0.0, (REAL)0.0};
    /* Above the box: the model starts at its greatest height. */
    start.height_m = (REAL)NAN;
    NAME_init(&state, &start);
    for (i = 0; i < ROWS; i++) {
        const WORD *row = VECTORS[i];
        NAME_input input;
        NAME_lift lift;
        input.thrust_n = real_of(row[0]);
        input.throttle = real_of(row[1]);
        input.height_m = real_of(row[2]);
        input.vehicle_velocity_mps = real_of(row[3]);
        input.deck_velocity_mps = real_of(row[4]);
        lift = NAME_step(&state, &input, real_of(row[5]));
        compare(i, lift.ratio, row[6]);
        compare(i, lift.force_n, row[7]);
    }
";

const TEST: &str = "\
/* Replays recorded vectors and compares the results bit for bit. */
#include \"NAME.h\"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#define ROWS @ROWS@

/* Inputs, dt and results of touchdown-flight. */
static const WORD VECTORS[ROWS][@COLUMNS@] = {
@TABLE@
};

static int failures = 0;

static REAL real_of(WORD bits)
{
    REAL x;
    (void)memcpy(&x, &bits, sizeof x);
    return x;
}

static void compare(int row, REAL found, WORD expected)
{
    WORD bits;
    (void)memcpy(&bits, &found, sizeof bits);
    if (bits != expected) {
        failures++;
        if (failures <= 5) {
            (void)printf(\"row %d: found %.17g, expected %.17g\\n\", row, (double)found,
                (double)real_of(expected));
        }
    }
}

int main(void)
{
    NAME_state state;
    int i;
@BODY@    if (failures == 0) {
        (void)printf(\"NAME: %d rows are the same bits\\n\", ROWS);
    }
    return (failures == 0) ? 0 : 1;
}
";
