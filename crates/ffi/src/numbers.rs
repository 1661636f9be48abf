//! The constants of enumerations, by the numbers that C gives.

/// Gives an enumeration `of`: its constant of a number. Needs `td_error` where it is called.
macro_rules! numbered {
    ($enumeration:ident: $($constant:ident),+) => {
        impl $enumeration {
            /// The constant of a number.
            pub(crate) fn of(number: u32) -> Result<Self, td_error> {
                match number {
                    $(_ if number == Self::$constant as u32 => Ok(Self::$constant),)+
                    _ => Err(td_error::UnknownValue),
                }
            }
        }

        // Does not compile if the list lacks a constant.
        const _: fn($enumeration) = |constant| match constant {
            $($enumeration::$constant => {})+
        };
    };
}

pub(crate) use numbered;
