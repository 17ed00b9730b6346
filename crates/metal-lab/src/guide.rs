//! The README and the guide: their code is compiled and run with the documentation tests.

#[doc = include_str!("../../../README.md")]
struct Readme;

#[doc = include_str!("../../../docs/guide/getting-started.md")]
struct GettingStarted;

#[doc = include_str!("../../../docs/guide/own-environment.md")]
struct OwnEnvironment;

#[doc = include_str!("../../../docs/guide/own-learner.md")]
struct OwnLearner;
