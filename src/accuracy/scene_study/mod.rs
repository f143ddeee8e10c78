//! A scene of the user's over steps and seeds: what its own observables make of them.
