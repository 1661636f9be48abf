//! A small expression language for numbers in columns.
//!
//! One language serves candidate terms of a regression (`x^2*y`), maps from
//! foreign log columns (`9.80665e-3 * "Thrust (gf)"`), printed models, row
//! filters (`time > 2 and not isnan(force)`) and exported code. An [`Expr`] is
//! parsed from text or built with operators, differentiated, simplified and
//! printed as text, LaTeX, C or Rust. A [`Program`] evaluates many of them
//! together, row by row or over whole columns, sharing what they have in common.
//!
//! ```
//! use sindy_expr::{Expr, Program, Scratch};
//!
//! let force = Expr::parse("0.804 - 0.088*f + 4.854*s^2")?;
//! assert_eq!(force.variables(), ["f", "s"]);
//! assert_eq!(force.derivative("s").to_string(), "9.708*s");
//!
//! let program = Program::compile(&[force], &["f", "s"])?;
//! let mut out = [0.0; 2];
//! program.eval_block(&[&[0.0, 1.0], &[0.0, 0.5]], &mut out, &mut Scratch::new());
//! assert!((out[1] - (0.804 - 0.088 + 4.854 * 0.25)).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Language
//!
//! | written | meaning |
//! | --- | --- |
//! | `1`, `.5`, `1e-3`, `pi`, `inf`, `nan` | constants |
//! | `x`, `motor.m1`, `σ` | a variable: letters, digits, `_`, and `.` inside |
//! | `"ESC signal (µs)"` | a variable of any name; `""` inside stands for one `"` |
//! | `or`, `and`, `not` | logic, loosest first; 0 and NaN are false, all else true |
//! | `<` `<=` `>` `>=` `==` `!=` | 1 or 0; every comparison with NaN is 0, also `!=`; they do not chain |
//! | `+` `-`, then `*` `/` | left to right |
//! | unary `-` | looser than `^`: `-x^2` is `-(x^2)` |
//! | `^` | right to left: `x^y^z` is `x^(y^z)` |
//! | `sqrt exp log sin cos tan asin acos atan tanh abs sign floor isnan` | functions of one argument, angles in radians, `log` to base e |
//! | `min max hypot atan2` | functions of two arguments; `min` and `max` are NaN when either argument is |
//! | `if(condition, a, b)` | `a` where the condition is true, else `b` |
//!
//! A text may have at most [`MAX_TEXT_BYTES`] bytes and nest at most
//! [`MAX_NESTING`] deep; a longer or deeper one is a [`ParseError`], and no text
//! makes the parser panic.
//!
//! # Arithmetic
//!
//! All values are `f64`. A value outside a function's domain (`log(-1)`,
//! `asin(2)`, `0/0`) is NaN and division by zero is infinite, as in IEEE 754;
//! nothing is an error at evaluation. `sign(0)` is 0. A constant whole exponent
//! of magnitude at most 64 is evaluated by multiplications only, in the fixed
//! order x²ᵏ = xᵏ·xᵏ, x²ᵏ⁺¹ = x²ᵏ·x, with x⁻ⁿ = 1/xⁿ and x⁰ = 1.

mod algebra;
mod arena;
mod code;
mod compile;
mod derivative;
mod display;
mod error;
mod expr;
mod factors;
mod latex;
mod lexer;
mod node;
mod parse;
mod program;
mod simplify;
mod suggest;

pub use code::{C_SUPPORT, RUST_SUPPORT, code_identifier};
pub use error::{CompileError, ParseError};
pub use expr::Expr;
pub use factors::Factor;
pub use parse::{MAX_NESTING, MAX_TEXT_BYTES};
pub use program::{Program, Scratch};
pub use suggest::nearest;
