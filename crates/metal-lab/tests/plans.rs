//! Every bad experiment file is refused with a sentence that can be acted on: file, line, field, what was found, what is
//! allowed. And no file, however damaged, makes the program panic.

use metal_lab::experiments;
use metal_lab::plan::{self, Plan, PlanError};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

const PAPER: &str = experiments::PAPER;

/// A file of one test, below the build folder.
fn written(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).unwrap();
    path
}

fn refused(result: Result<Plan, PlanError>) -> String {
    match result {
        Ok(_) => "nothing was refused".to_owned(),
        Err(error) => error.to_string(),
    }
}

/// One way to spoil `paper.toml`: the text that is replaced, what replaces it, where the error must point (a piece of the
/// line), and what it must say.
type Change = (&'static str, &'static str, &'static str, &'static [&'static str]);

/// Applies the changes one by one and collects every message that falls short.
fn check(name: &str, changes: &[Change]) {
    let mut failures = Vec::new();
    for (old, new, mark, wanted) in changes {
        assert!(PAPER.contains(old), "{old:?} is not in paper.toml any more");
        let text = PAPER.replacen(old, new, 1);
        let at = text.find(mark).unwrap_or_else(|| panic!("{mark:?} is not in the changed file"));
        let path = written(name, &text);
        let place = format!("{}:{}: ", path.display(), text[..at].matches('\n').count() + 1);
        let message = refused(plan::load(&path, &[]));
        let missing: Vec<&str> = wanted.iter().copied().filter(|w| !message.contains(w)).collect();
        if !message.starts_with(&place) || !missing.is_empty() {
            failures
                .push(format!("{new:?}\n  place   {place}\n  missing {missing:?}\n  message {message}\n"));
        }
    }
    assert!(failures.is_empty(), "{} of {}:\n{}", failures.len(), changes.len(), failures.join("\n"));
}

/// The first phase with a rate of its own.
const FOA_RATE: &str = "rate = { constant = 0.2 }\nexploration = { soft_max";

#[test]
fn unknown_keys_are_refused_where_they_stand() {
    check(
        "unknown-keys.toml",
        &[
            (
                "title =",
                "titel = 1\ntitle =",
                "titel",
                &["titel", "unknown field", "expected one of", "`title`"],
            ),
            (
                "[evaluation]",
                "[evaluations]",
                "[evaluations]",
                &["unknown field `evaluations`", "`evaluation`"],
            ),
            ("runs = 500", "run = 500", "run = 500", &["evaluation", "unknown field `run`", "`runs`"]),
            (
                "[learner.tiny.absp]",
                "[learner.tiny.absp]\nspeed = 1.0",
                "speed",
                &["learner.tiny.absp", "`speed`"],
            ),
            (
                "[learner.acl.mlp]",
                "[learner.acl.mlp]\nadam = { lr = 1.0 }",
                "adam",
                &["learner.acl.mlp.adam", "`lr`"],
            ),
            (
                "[learner.acl.mlp]",
                "[learner.acl.rnn]",
                "[learner.acl.rnn]",
                &["learner.acl", "`rnn`", "`mlp`"],
            ),
            (
                "scenario = \"mix\"",
                "weather = 1",
                "weather",
                &["environment.highway", "`weather`", "`scenario`"],
            ),
            (
                "[environment.highway]",
                "[environment.ocean]",
                "[environment.ocean]",
                &["`ocean`", "`highway`"],
            ),
            (
                "motor_target = \"literal\"",
                "motor = 1",
                "motor = 1",
                &["attention.acl_paper.settings", "`motor_target`"],
            ),
            (
                "rate = \"full\"",
                "rate = \"full\"\nrates = 1",
                "rates",
                &["phase.demonstration", "`rates`", "`rate`"],
            ),
            ("[member.MN]", "[member.MN]\nsensor = 1", "sensor = 1", &["member.MN", "`sensor`", "`sensors`"]),
            ("[policy.blind]", "[policy.blind]\nfoo = 1", "foo", &["policy.blind", "`foo`", "`acting`"]),
            ("like = \"foa\"", "likes = \"foa\"", "likes", &["subsets", "`likes`", "`like`"]),
            (
                "null = 0.0 }",
                "nil = 0.0 }",
                "nil",
                &["attention.acl_paper.settings.encoding", "`nil`", "`null`"],
            ),
        ],
    );
}

#[test]
fn wrong_types_are_refused_where_they_stand() {
    check(
        "wrong-types.toml",
        &[
            (
                "runs = 500",
                "runs = \"many\"",
                "\"many\"",
                &["evaluation.runs", "string \"many\"", "expected usize"],
            ),
            ("runs = 500", "runs = -5", "-5", &["evaluation.runs", "-5", "expected usize"]),
            ("runs = 500", "runs = 2.5", "2.5", &["evaluation.runs", "2.5", "expected usize"]),
            ("rate = \"full\"", "rate = 0.2", "rate = 0.2", &["phase.demonstration.rate"]),
            (
                "rate = \"full\"",
                "rate = \"fast\"",
                "\"fast\"",
                &["phase.demonstration.rate", "`fast`", "`full`"],
            ),
            ("steps = 200", "step = 200", "step = 200", &["phase.demonstration.budget", "`step`", "`steps`"]),
            (
                "scenario = \"mix\"",
                "scenario = \"rain\"",
                "\"rain\"",
                &["environment.highway.scenario", "`rain`", "`mix`"],
            ),
            ("roads = \"training\"", "roads = 3", "roads = 3", &["environment.highway.roads"]),
            (
                "sensors = [\"MN\"]",
                "sensors = \"MN\"",
                "sensors = \"MN\"",
                &["member.MN.sensors", "expected a sequence"],
            ),
            ("{ solo = \"FOA\" }", "{ duet = \"FOA\" }", "duet", &["phase.foa.acting", "`duet`", "`solo`"]),
            (
                "\"max_confidence\"",
                "\"loudest\"",
                "\"loudest\"",
                &["phase.fusion.acting.fusion", "`loudest`", "`borda`"],
            ),
            ("acting = { solo = \"FOA\" }", "", "[phase.foa]", &["phase.foa", "missing field `acting`"]),
            ("title =", "[title\n#", "[title", &[]),
        ],
    );
}

#[test]
fn impossible_numbers_are_refused_with_what_is_allowed() {
    check(
        "impossible-numbers.toml",
        &[
            (
                FOA_RATE,
                "rate = { constant = 0.0 }\nexploration = { soft_max",
                "constant = 0.0",
                &["phase.foa.rate", "0: ", "(0, 1]"],
            ),
            (
                FOA_RATE,
                "rate = { average = 1.5 }\nexploration = { soft_max",
                "average = 1.5",
                &["phase.foa.rate.average", "1.5: ", "(0, 1]"],
            ),
            (
                FOA_RATE,
                "rate = { constant = nan }\nexploration = { soft_max",
                "nan",
                &["phase.foa.rate.constant", "NaN", "(0, 1]"],
            ),
            (
                "rate = \"full\"",
                "rate = \"full\"\ncredit = { gamma = 1.0 }",
                "gamma",
                &["phase.demonstration.credit.gamma", "1: ", "[0, 1)"],
            ),
            (
                "rate = \"full\"",
                "rate = \"full\"\ncredit = { lambda = 2 }",
                "lambda",
                &["phase.demonstration.credit.lambda", "2: ", "[0, 1]"],
            ),
            (
                "{ steps = 200 }",
                "{ steps = 0 }",
                "steps = 0",
                &["phase.demonstration.budget.steps", "0: ", "between 1 and"],
            ),
            (
                "episodes = 1200",
                "episodes = 999999999999",
                "999999999999",
                &["phase.foa.budget.episodes", "999999999999: ", "between 1 and"],
            ),
            (
                "to = 0.5, until = 0.8",
                "to = 0.5, until = 0.0",
                "until = 0.0",
                &["phase.foa.exploration.soft_max.until", "0: ", "(0, 1]"],
            ),
            (
                "from = 5.0, to = 0.5",
                "from = inf, to = 0.5",
                "from = inf",
                &["phase.foa.exploration.soft_max.from", "inf: ", "above 0"],
            ),
            (
                "from = 0.2, to = 0.02",
                "from = 1.2, to = 0.02",
                "from = 1.2",
                &["phase.fusion.exploration.random.from", "1.2: ", "(0, 1]"],
            ),
            (
                "from = 0.2, to = 0.02",
                "from = 0.2, to = 0.0",
                "to = 0.0",
                &["phase.fusion.exploration.random.to", "0: ", "(0, 1]"],
            ),
            (
                "price_ramp = 0.0",
                "price_ramp = 1.5",
                "price_ramp = 1.5",
                &["attention.acl_paper.settings.price_ramp", "1.5: ", "[0, 1]"],
            ),
            (
                "price_ramp = 0.0",
                "min_looks = 3\nmax_looks = 2",
                "min_looks = 3",
                &["attention.acl_paper.settings.min_looks", "3 looks", "2 at most"],
            ),
            (
                "price_ramp = 0.0",
                "rate = { constant = 0 }",
                "rate = { constant = 0 }",
                &["attention.acl_paper.settings.rate.constant", "(0, 1]"],
            ),
            (
                "null = 0.0",
                "null = nan",
                "null = nan",
                &["attention.acl_paper.settings.encoding.null", "NaN", "finite"],
            ),
            ("runs = 500", "runs = 0", "runs = 0", &["evaluation.runs", "0: ", "between 1 and"]),
            (
                "screening_share = 0.25",
                "screening_share = 0",
                "screening_share",
                &["subsets.screening_share", "0: ", "(0, 1]"],
            ),
            (
                "screening_seeds = 2",
                "screening_seeds = 0",
                "screening_seeds",
                &["subsets.screening_seeds", "0: "],
            ),
            (
                "screening_runs = 60",
                "screening_runs = 0",
                "screening_runs",
                &["subsets.screening_runs", "0: "],
            ),
            ("confirmed = 3", "confirmed = 0", "confirmed", &["subsets.confirmed", "0: "]),
            (
                "random_looks = 2.0",
                "random_looks = 0.5",
                "random_looks",
                &["policy.random.acting.random_looks", "0.5: ", "at least 1"],
            ),
            (
                "scenario = \"mix\"",
                "horizon = 0",
                "horizon",
                &["environment.highway.horizon", "0: ", "between 1 and"],
            ),
            (
                "roads = \"training\"",
                "roads = { seeds = [] }",
                "seeds = []",
                &["environment.highway.roads.seeds", "empty", "at least one road"],
            ),
            (
                "[learner.acl.mlp]",
                "[learner.acl.mlp]\ncapacity = 0",
                "[learner.acl.mlp]",
                &["learner.acl", "mlp.capacity = 0", "must be"],
            ),
            (
                "scenario = \"mix\"",
                "task = { weights = [50, 30, 20, 2], prices = [1.5, 2, 2, 1.5, 2, 2, -1] }",
                "task",
                &["environment.highway.task.prices", "-1: ", "at least 0"],
            ),
        ],
    );
}

/// All members of the fusion phase.
const EVERYBODY: &str = "[\"MN\", \"LN\", \"RN\", \"MF\", \"LF\", \"RF\", \"IR\", \"FOA\"]";

#[test]
fn names_must_mean_something() {
    check(
        "names.toml",
        &[
            (EVERYBODY, "[]", "roster = []", &["phase.demonstration.roster", "empty", "at least one member"]),
            (
                EVERYBODY,
                "[\"MN\", \"XX\"]",
                "\"XX\"",
                &["phase.demonstration.roster", "member `XX`", "known: ", "FOA"],
            ),
            (EVERYBODY, "[\"MN\", \"MN\"]", "\"MN\", \"MN\"", &["phase.demonstration.roster", "`MN` twice"]),
            (
                "sensors = [\"MN\"]",
                "sensors = [\"UV\"]",
                "UV",
                &["member.MN.sensors", "sensor `UV`", "known: MN, "],
            ),
            ("sensors = [\"MN\"]", "sensors = []", "sensors = []", &["member.MN.sensors", "empty"]),
            (
                "sensors = [\"MN\"]",
                "sensors = [\"MN\", \"MN\"]",
                "\"MN\", \"MN\"",
                &["member.MN.sensors", "`MN` twice"],
            ),
            (
                "learner = \"tiny\"",
                "learner = \"huge\"",
                "huge",
                &["member.MN.learner", "learner `huge`", "known: acl"],
            ),
            (
                "learner = \"acl\"",
                "learner = \"none\"",
                "\"none\"",
                &["attention.acl.learner", "learner `none`", "known: "],
            ),
            (
                "{ attention = \"acl\" }",
                "{ attention = \"a\" }",
                "\"a\"",
                &["phase.attention.acting.attention", "`a`", "known: acl, acl_paper"],
            ),
            (
                "{ solo = \"FOA\" }",
                "{ solo = \"MN\" }",
                "solo = \"MN\"",
                &["phase.foa.acting.solo", "member `MN`", "known: FOA"],
            ),
            (
                "after = \"demonstration\"",
                "after = \"birth\"",
                "birth",
                &["phase.foa.after", "phase `birth`", "known: attention, "],
            ),
            (
                "after = \"demonstration\"",
                "after = \"foa\"",
                "after = \"foa\"",
                &["phase.foa.after", "from `foa` itself"],
            ),
            (
                "bootstrap = \"FOA\"",
                "bootstrap = \"God\"",
                "God",
                &["phase.fusion.bootstrap", "member `God`", "known: MN"],
            ),
            (
                "[policy.foa]\nafter = \"foa\"",
                "[policy.foa]\nafter = \"fo\"",
                "\"fo\"",
                &["policy.foa.after", "phase `fo`", "known: "],
            ),
            (
                "\"mix\", \"free_road\"",
                "\"rain\"",
                "\"rain\"",
                &["evaluation.scenarios", "scenario `rain`", "known: mix"],
            ),
            ("like = \"foa\"", "like = \"nobody\"", "nobody", &["subsets.like", "phase `nobody`", "known: "]),
            (
                "budget_of = [\"demonstration\", \"fusion\"",
                "budget_of = [\"sleep\"",
                "sleep",
                &["subsets.budget_of", "phase `sleep`"],
            ),
            (
                "budget_of = [\"demonstration\", \"fusion\", \"attention\"]",
                "budget_of = []",
                "budget_of",
                &["subsets.budget_of"],
            ),
            ("learner = \"subset\"", "learner = \"sub\"", "\"sub\"", &["subsets.learner", "learner `sub`"]),
            (
                "[phase.foa]",
                "[phase.\"../../foa\"]",
                "[phase.demonstration]",
                &["phase: ", "`../../foa`", "letters, digits"],
            ),
            (
                "[policy.blind]",
                "[policy.best_fixed]",
                "[policy.best_fixed]",
                &["policy.best_fixed", "kept for"],
            ),
        ],
    );
}

#[test]
fn parts_that_nobody_can_play_are_refused() {
    check(
        "parts.toml",
        &[
            (
                "sensing = \"everyone\"",
                "",
                "[phase.demonstration]",
                &["phase.demonstration.sensing", "nobody would learn", "everyone"],
            ),
            (
                "acting = \"advisor\"",
                "acting = \"blind\"",
                "\"blind\"",
                &["phase.demonstration.acting", "only a policy"],
            ),
            (
                "acting = { attention = \"acl\" }\nrate",
                "acting = { attention = \"acl\" }\nbootstrap = \"MN\"\nrate",
                "bootstrap = \"MN\"",
                &["phase.attention.bootstrap", "`MN` does not look before every move"],
            ),
            (
                "after = \"attention\"",
                "after = \"fusion\"",
                "after = \"fusion\"\nroster = [\"MN\", \"LN\", \"RN\", \"MF\", \"LF\", \"RF\", \"IR\"]\nacting = { attention = \"acl\" }\n\n[policy.acl_paper]",
                &["policy.acl.after", "`acl` is not trained in phase `fusion`"],
            ),
            ("after = \"attention\"\n", "", "[policy.acl]", &["policy.acl.after", "missing", "which phase"]),
            (
                "after = \"attention\"\nroster = [\"MN\", ",
                "after = \"attention\"\nroster = [",
                "roster = [\"LN\"",
                &["policy.acl.roster", "born for the roster of phase `attention`", "MN, LN"],
            ),
            (
                "{ fusion = \"max_confidence\" }",
                "{ fusion = { weighted_log_opinion_pool = { weights = [1, 2] } } }",
                "weights = [1, 2]",
                &["phase.fusion.acting.fusion", "2 weights for 8 agents"],
            ),
            (
                "{ fusion = \"log_opinion_pool\" }",
                "{ fusion = { owa = { weights = [1, -2] } } }",
                "weights = [1, -2]",
                &["policy.fusion_log_pool.acting.fusion", "weight 1", "-2", "at least 0"],
            ),
            (
                "{ fusion = \"log_opinion_pool\" }",
                "{ fusion = { owa = { weights = [0.0] } } }",
                "weights = [0.0]",
                &["policy.fusion_log_pool.acting.fusion", "add up to nothing"],
            ),
            (
                "[learner.tiny.absp]",
                "[learner.tiny.given]",
                "learner = \"tiny\"",
                &["member.MN.learner", "one number per action"],
            ),
            (
                "[learner.acl.mlp]",
                "[learner.acl.given]",
                "learner = \"acl\"",
                &["attention.acl.learner", "one number per action"],
            ),
            (
                "[learner.subset.mlp]",
                "[learner.subset.given]",
                "learner = \"subset\"",
                &["subsets.learner", "one number per action"],
            ),
        ],
    );
}

#[test]
fn a_file_that_is_not_there_is_named() {
    let message = refused(plan::load(Path::new("no/such/plan.toml"), &[]));
    assert!(message.starts_with("no/such/plan.toml: cannot be read: "), "{message}");
}

#[test]
fn the_phase_that_goes_in_circles_is_named_and_not_one_behind_it() {
    let circle = PAPER.replacen(
        "after = \"demonstration\"\nroster = [\"MN\"",
        "after = \"attention\"\nroster = [\"MN\"",
        1,
    );
    let message = refused(plan::parse(&circle, &[]));
    assert!(
        message.contains("phase.attention.after: `fusion` starts, in the end, from `attention`"),
        "{message}"
    );
}

#[test]
fn mistakes_on_the_command_line_are_called_by_their_assignment() {
    let rows: [(&[&str], &[&str]); 9] = [
        (&["phase.fusion.rate"], &["--set phase.fusion.rate: ", "key=value"]),
        (&["title.long=1"], &["--set title.long=1: ", "cannot go into `title`", "string"]),
        (&["evaluation.run=3"], &["--set evaluation.run=3: ", "unknown field `run`", "`runs`"]),
        (&["evaluation.runs=many"], &["--set evaluation.runs=many: ", "string \"many\"", "evaluation.runs"]),
        (&["evaluation.runs=0"], &["--set evaluation.runs=0: evaluation.runs: 0: between 1"]),
        (
            &["evaluation.runs=5", "phase.foa.rate.constant=2", "title=x"],
            &["--set phase.foa.rate.constant=2: ", "(0, 1]"],
        ),
        (&["phase.foa.budget.steps=2"], &["--set phase.foa.budget.steps=2: ", "phase.foa.budget"]),
        (&["=3"], &["--set =3: "]),
        (
            &["phase.foa.roster=[\"MN\""],
            &["--set phase.foa.roster=[\"MN\": ", "phase.foa.roster", "sequence"],
        ),
    ];
    let path = written("assignments.toml", PAPER);
    for (assignments, wanted) in rows {
        let assignments: Vec<String> = assignments.iter().map(|a| (*a).to_owned()).collect();
        let message = refused(plan::load(&path, &assignments));
        assert!(message.starts_with(&format!("{}: ", path.display())), "no line is to blame: {message}");
        assert!(wanted.iter().all(|w| message.contains(w)), "{assignments:?}: {wanted:?} in {message}");
    }
}

#[test]
fn assignments_that_only_fit_together_are_taken_together() {
    let sets = ["policy.two.acting.solo=FOA", "policy.two.after=foa", "policy.two.roster=[\"FOA\"]"]
        .map(String::from);
    let plan = plan::parse(PAPER, &sets).unwrap();
    assert_eq!(plan.file.policy["two"], plan.file.policy["foa"]);
}

#[test]
fn every_experiment_that_ships_is_possible() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../experiments");
    let files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    let plans: Vec<&PathBuf> = files.iter().filter(|f| f.extension().is_some_and(|e| e == "toml")).collect();
    assert!(plans.len() >= 3);
    for path in plans {
        let plan = plan::load(path, &[]).unwrap_or_else(|e| panic!("{e}"));
        let again = plan::parse(&toml::to_string(&plan.file).unwrap(), &[]).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(
            again.file,
            plan.file,
            "{}: a plan that was written down is the same plan",
            path.display()
        );
    }
}

#[test]
fn weights_of_a_pool_follow_their_members_wherever_these_stand() {
    let pool = |roster: &str, weights: &str| {
        let text = PAPER.replacen(
            &format!("roster = {EVERYBODY}\nacting = {{ fusion = \"log_opinion_pool\" }}"),
            &format!("roster = {roster}\nacting = {{ fusion = {{ weighted_log_opinion_pool = {{ weights = {weights} }} }} }}"),
            1,
        );
        plan::parse(&text, &[]).unwrap().file.policy["fusion_log_pool"].clone()
    };
    assert_eq!(
        pool("[\"FOA\", \"IR\", \"MN\"]", "[8, 7, 1]"),
        pool("[\"MN\", \"IR\", \"FOA\"]", "[1, 7, 8]")
    );
}

/// A few bytes of a text set to others.
fn damaged(text: &str, changes: &[(prop::sample::Index, u8)]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for (index, byte) in changes {
        let at = index.index(bytes.len());
        bytes[at] = *byte;
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_damage_never_panics(changes in prop::collection::vec((any::<prop::sample::Index>(), 0x20_u8..0x7f), 1..4)) {
        let text = damaged(PAPER, &changes);
        if let Err(error) = plan::parse(&text, &[]) {
            prop_assert!(!error.to_string().is_empty());
        }
    }

    #[test]
    fn random_assignments_never_panic(key in "[a-z_.]{0,12}", value in "[ -~]{0,12}", whole in any::<bool>()) {
        let key = if whole { format!("phase.foa.{key}") } else { key };
        let _ = plan::parse(PAPER, &[format!("{key}={value}")]);
    }

    #[test]
    fn random_numbers_in_place_of_any_number_never_panic(nth in any::<prop::sample::Index>(), value in prop_oneof![
        Just("0".to_owned()), Just("-1".to_owned()), Just("inf".to_owned()), Just("nan".to_owned()),
        Just("9223372036854775807".to_owned()), Just("1e308".to_owned()), Just("5e-324".to_owned()),
    ]) {
        let places: Vec<usize> = PAPER.match_indices(" = ").map(|(i, _)| i + 3)
            .filter(|&i| PAPER.as_bytes()[i].is_ascii_digit()).collect();
        let at = places[nth.index(places.len())];
        let length = PAPER[at..].find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap();
        let text = format!("{}{value}{}", &PAPER[..at], &PAPER[at + length..]);
        let _ = plan::parse(&text, &[]);
    }
}
