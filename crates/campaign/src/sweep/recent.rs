//! What was used last and is to be shared.

use std::sync::{Arc, Mutex, PoisonError};

/// A key and its value.
type KeyedValue<T> = (u64, Arc<T>);

/// The values of the keys that were asked for last: two for each thread, for a thread that goes from one key to the
/// next leaves the first one to others.
#[derive(Debug)]
pub(super) struct RecentlyUsed<T> {
    /// The longest unused one first.
    values: Arc<Mutex<Vec<KeyedValue<T>>>>,
}

impl<T> RecentlyUsed<T> {
    /// The value of a key, which is built where it is not there.
    ///
    /// # Errors
    /// Those of `build`.
    pub(super) fn shared<E>(
        &self,
        key: u64,
        build: impl FnOnce() -> Result<T, E>,
    ) -> Result<Arc<T>, E> {
        if let Some(value) = self.used(key, None) {
            return Ok(value);
        }
        // Others may go on meanwhile; of two threads that build the same one, the later takes the other's.
        let built = Arc::new(build()?);
        Ok(self.used(key, Some(&built)).unwrap_or(built))
    }

    /// The value of a key, now the last one used, or else `built`.
    fn used(&self, key: u64, built: Option<&Arc<T>>) -> Option<Arc<T>> {
        let mut values = self.values.lock().unwrap_or_else(PoisonError::into_inner);
        let found = values.iter().position(|(of, _)| *of == key);
        let value = match found {
            Some(place) => values.remove(place).1,
            None => built?.clone(),
        };
        if values.len() >= 2 * rayon::current_num_threads() {
            values.remove(0);
        }
        values.push((key, value.clone()));
        Some(value)
    }
}

impl<T> Clone for RecentlyUsed<T> {
    fn clone(&self) -> Self {
        Self {
            values: self.values.clone(),
        }
    }
}

impl<T> Default for RecentlyUsed<T> {
    fn default() -> Self {
        Self {
            values: Arc::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    #[test]
    fn prop_two_values_a_thread_are_shared_and_no_more_are_kept() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3);
        pool.build().unwrap().install(|| {
            let recent = RecentlyUsed::default();
            let get = |key: u64| recent.shared(key, || Ok::<_, Infallible>(key)).unwrap();
            let first: Vec<_> = (0..6).map(get).collect();
            // In whatever order they are asked for.
            for key in [5, 0, 3, 0, 1, 4, 2, 5] {
                assert!(Arc::ptr_eq(&get(key), &first[key as usize]), "{key}");
            }
            // One more takes the place of the longest unused one, which is 3.
            assert_eq!(*get(6), 6);
            for key in [5, 2, 4, 1, 0] {
                assert!(Arc::ptr_eq(&get(key), &first[key as usize]), "{key}");
            }
            assert!(!Arc::ptr_eq(&get(3), &first[3]));
            assert_eq!(recent.values.lock().unwrap().len(), 6);
        });
    }

    #[test]
    fn prop_what_another_thread_has_built_meanwhile_is_taken_and_errors_keep_nothing() {
        let recent = RecentlyUsed::default();
        assert_eq!(recent.shared(0, || Err("no")), Err("no"));
        let mut other = None;
        let own = recent.shared(0, || {
            other = recent.shared(0, || Ok::<_, &str>(1)).ok();
            Ok::<_, &str>(2)
        });
        assert!(Arc::ptr_eq(&own.unwrap(), &other.unwrap()));
    }
}
