//! Ways to spoil `paper.toml`, one a line.

/// One way to spoil `paper.toml`: the text that is replaced, what replaces it, where the error must point (a piece of the
/// line), and what it must say.
pub type Change = (&'static str, &'static str, &'static str, &'static [&'static str]);

/// The first phase with a rate of its own.
const FOA_RATE: &str = "rate = { constant = 0.2 }\nexploration = { soft_max";

/// All members of the fusion phase.
pub const EVERYBODY: &str = "[\"MN\", \"LN\", \"RN\", \"MF\", \"LF\", \"RF\", \"IR\", \"FOA\"]";

/// How fixed choices learn: by the recipe of attention.
const FIXED: &str = "like = \"attention\"\nbudget_of = [\"attention\"]\namong = [\"RN\", \"MF\", \"RF\", \"MN+RN\", \"RN/2\", \"RN/3\", \
                     \"MF/2\", \"MN+RN/3\", \"RN+MF/3\"]";

/// The same with the head of its table.
const SUBSETS: &str = "[subsets]\nlike = \"attention\"\nbudget_of = [\"attention\"]\namong = [\"RN\", \"MF\", \"RF\", \"MN+RN\", \"RN/2\", \
                       \"RN/3\", \"MF/2\", \"MN+RN/3\", \"RN+MF/3\"]";

/// Keys nobody knows: at the top, in tables, in settings of learners, worlds, attention.
#[rustfmt::skip]
pub const UNKNOWN_KEYS: &[Change] = &[
    ("title =", "titel = 1\ntitle =", "titel", &["titel", "unknown field", "expected one of", "`title`"]),
    ("[evaluation]", "[evaluations]", "[evaluations]", &["unknown field `evaluations`", "`evaluation`"]),
    ("runs = 500", "run = 500", "run = 500", &["evaluation", "unknown field `run`", "`runs`"]),
    ("[learner.paper.absp]", "[learner.paper.absp]\nspeed = 1.0", "speed", &["learner.paper.absp", "`speed`"]),
    ("[learner.acl.mlp]", "[learner.acl.mlp]\nadam = { lr = 1.0 }", "adam", &["learner.acl.mlp.adam", "`lr`"]),
    ("[learner.acl.mlp]", "[learner.acl.rnn]", "[learner.acl.rnn]", &["learner.acl", "`rnn`", "`mlp`"]),
    ("scenario = \"mix\"", "weather = 1", "weather", &["environment.highway", "`weather`", "`scenario`"]),
    ("[environment.highway]", "[environment.ocean]", "[environment.ocean]", &["`ocean`", "`highway`"]),
    ("motor_target = \"literal\"", "motor = 1", "motor = 1", &["attention.acl_paper.settings", "`motor_target`"]),
    ("rate = \"full\"", "rate = \"full\"\nrates = 1", "rates", &["phase.demonstration", "`rates`", "`rate`"]),
    ("[member.MN]", "[member.MN]\nsensor = 1", "sensor = 1", &["member.MN", "`sensor`", "`sensors`"]),
    ("[policy.blind]", "[policy.blind]\nfoo = 1", "foo", &["policy.blind", "`foo`", "`acting`"]),
    ("like = \"attention\"", "likes = \"attention\"", "likes", &["subsets", "`likes`", "`like`"]),
    ("null = 0.0 }", "nil = 0.0 }", "nil", &["attention.acl_paper.settings.encoding", "`nil`", "`null`"]),
];

/// Values of another type than the field.
#[rustfmt::skip]
pub const WRONG_TYPES: &[Change] = &[
    ("runs = 500", "runs = \"many\"", "\"many\"", &["evaluation.runs", "string \"many\"", "expected usize"]),
    ("runs = 500", "runs = -5", "-5", &["evaluation.runs", "-5", "expected usize"]),
    ("runs = 500", "runs = 2.5", "2.5", &["evaluation.runs", "2.5", "expected usize"]),
    ("rate = \"full\"", "rate = 0.2", "rate = 0.2", &["phase.demonstration.rate"]),
    ("rate = \"full\"", "rate = \"fast\"", "\"fast\"", &["phase.demonstration.rate", "`fast`", "`full`"]),
    ("steps = 200", "step = 200", "step = 200", &["phase.demonstration.budget", "`step`", "`steps`"]),
    ("scenario = \"mix\"", "scenario = \"rain\"", "\"rain\"", &["environment.highway.scenario", "`rain`", "`mix`"]),
    ("roads = \"training\"", "roads = 3", "roads = 3", &["environment.highway.roads"]),
    ("sensors = [\"MN\"]", "sensors = \"MN\"", "sensors = \"MN\"", &["member.MN.sensors", "expected a sequence"]),
    ("{ solo = \"FOA\" }", "{ duet = \"FOA\" }", "duet", &["phase.foa.acting", "`duet`", "`solo`"]),
    ("\"max_confidence\"", "\"loudest\"", "\"loudest\"", &["phase.fusion.acting.fusion", "`loudest`", "`borda`"]),
    ("acting = { solo = \"FOA\" }", "", "[phase.foa]", &["phase.foa", "missing field `acting`"]),
    ("title =", "[title\n#", "[title", &[]),
];

/// Numbers outside their range.
#[rustfmt::skip]
pub const IMPOSSIBLE_NUMBERS: &[Change] = &[
    (FOA_RATE, "rate = { constant = 0.0 }\nexploration = { soft_max", "constant = 0.0", &["phase.foa.rate", "0: ", "(0, 1]"]),
    (FOA_RATE, "rate = { average = 1.5 }\nexploration = { soft_max", "average = 1.5", &["phase.foa.rate.average", "1.5: ", "(0, 1]"]),
    (FOA_RATE, "rate = { constant = nan }\nexploration = { soft_max", "nan", &["phase.foa.rate.constant", "NaN", "(0, 1]"]),
    ("rate = \"full\"", "rate = \"full\"\ncredit = { gamma = 1.0 }", "gamma", &["phase.demonstration.credit.gamma", "1: ", "[0, 1)"]),
    ("rate = \"full\"", "rate = \"full\"\ncredit = { lambda = 2 }", "lambda", &["phase.demonstration.credit.lambda", "2: ", "[0, 1]"]),
    ("{ steps = 200 }", "{ steps = 0 }", "steps = 0", &["phase.demonstration.budget.steps", "0: ", "between 1 and"]),
    ("episodes = 1200", "episodes = 999999999999", "999999999999", &["phase.foa.budget.episodes", "999999999999: ", "between 1 and"]),
    ("to = 0.5, until = 0.8", "to = 0.5, until = 0.0", "until = 0.0", &["phase.foa.exploration.soft_max.until", "0: ", "(0, 1]"]),
    ("from = 5.0, to = 0.5", "from = inf, to = 0.5", "from = inf", &["phase.foa.exploration.soft_max.from", "inf: ", "above 0"]),
    ("from = 0.2, to = 0.02", "from = 1.2, to = 0.02", "from = 1.2", &["phase.fusion.exploration.random.from", "1.2: ", "(0, 1]"]),
    ("from = 0.2, to = 0.02", "from = 0.2, to = 0.0", "to = 0.0", &["phase.fusion.exploration.random.to", "0: ", "(0, 1]"]),
    ("price_ramp = 0.0", "price_ramp = 1.5", "price_ramp = 1.5", &["attention.acl_paper.settings.price_ramp", "1.5: ", "[0, 1]"]),
    ("price_ramp = 0.0", "min_looks = 3\nmax_looks = 2", "min_looks = 3", &["attention.acl_paper.settings.min_looks", "3 looks", "2 at most"]),
    ("price_ramp = 0.0", "rate = { constant = 0 }", "rate = { constant = 0 }", &["attention.acl_paper.settings.rate.constant", "(0, 1]"]),
    ("null = 0.0", "null = nan", "null = nan", &["attention.acl_paper.settings.encoding.null", "NaN", "finite"]),
    ("runs = 500", "runs = 0", "runs = 0", &["evaluation.runs", "0: ", "between 1 and"]),
    ("screening_share = 0.25", "screening_share = 0", "screening_share", &["subsets.screening_share", "0: ", "(0, 1]"]),
    ("screening_seeds = 2", "screening_seeds = 0", "screening_seeds", &["subsets.screening_seeds", "0: "]),
    ("screening_runs = 60", "screening_runs = 0", "screening_runs", &["subsets.screening_runs", "0: "]),
    ("confirmed = 2", "confirmed = 0", "confirmed = 0", &["subsets.confirmed", "0: "]),
    ("random_looks = 2.0", "random_looks = 0.5", "random_looks", &["policy.random.acting.random_looks", "0.5: ", "at least 1"]),
    ("scenario = \"mix\"", "horizon = 0", "horizon", &["environment.highway.horizon", "0: ", "between 1 and"]),
    ("roads = \"training\"", "roads = { seeds = [] }", "seeds = []", &["environment.highway.roads.seeds", "empty", "at least one road"]),
    ("[learner.acl.mlp]", "[learner.acl.mlp]\ncapacity = 0", "[learner.acl.mlp]", &["learner.acl", "mlp.capacity = 0", "must be"]),
    (
        "scenario = \"mix\"",
        "task = { weights = [50, 30, 20, 2], prices = [1.5, 2, 2, 1.5, 2, 2, -1] }",
        "task",
        &["environment.highway.task.prices", "-1: ", "at least 0"],
    ),
];

/// Names that mean nothing, and lists that name nobody.
#[rustfmt::skip]
pub const NAMES: &[Change] = &[
    (EVERYBODY, "[]", "roster = []", &["phase.demonstration.roster", "empty", "at least one member"]),
    (EVERYBODY, "[\"MN\", \"XX\"]", "\"XX\"", &["phase.demonstration.roster", "member `XX`", "known: ", "FOA"]),
    (EVERYBODY, "[\"MN\", \"MN\"]", "\"MN\", \"MN\"", &["phase.demonstration.roster", "`MN` twice"]),
    ("sensors = [\"MN\"]", "sensors = [\"UV\"]", "UV", &["member.MN.sensors", "sensor `UV`", "known: MN, "]),
    ("sensors = [\"MN\"]", "sensors = []", "sensors = []", &["member.MN.sensors", "empty"]),
    ("sensors = [\"MN\"]", "sensors = [\"MN\", \"MN\"]", "\"MN\", \"MN\"", &["member.MN.sensors", "`MN` twice"]),
    ("learner = \"tiny\"", "learner = \"huge\"", "huge", &["member.MN.learner", "learner `huge`", "known: acl"]),
    ("learner = \"acl\"", "learner = \"none\"", "\"none\"", &["attention.acl_phase3.learner", "learner `none`", "known: "]),
    ("{ attention = \"acl\" }", "{ attention = \"a\" }", "\"a\"", &["phase.attention.acting.attention", "`a`", "known: acl, acl_decision, acl_paper, acl_phase3"]),
    ("{ solo = \"FOA\" }", "{ solo = \"MN\" }", "solo = \"MN\"", &["phase.foa.acting.solo", "member `MN`", "known: FOA"]),
    ("after = \"demonstration\"", "after = \"birth\"", "birth", &["phase.foa.after", "phase `birth`", "known: attention, "]),
    ("after = \"demonstration\"", "after = \"foa\"", "after = \"foa\"", &["phase.foa.after", "from `foa` itself"]),
    ("bootstrap = \"FOA\"", "bootstrap = \"God\"", "God", &["phase.fusion.bootstrap", "member `God`", "known: MN"]),
    ("[policy.foa]\nafter = \"foa\"", "[policy.foa]\nafter = \"fo\"", "\"fo\"", &["policy.foa.after", "phase `fo`", "known: "]),
    ("\"mix\", \"free_road\"", "\"rain\"", "\"rain\"", &["evaluation.scenarios", "scenario `rain`", "known: mix"]),
    ("like = \"attention\"", "like = \"nobody\"", "like = \"nobody\"", &["subsets.like", "phase `nobody`", "known: "]),
    ("budget_of = [\"attention\"]", "budget_of = [\"sleep\"]", "sleep", &["subsets.budget_of", "phase `sleep`"]),
    ("budget_of = [\"attention\"]", "budget_of = []", "budget_of", &["subsets.budget_of"]),
    ("\"RN/2\"", "\"MN+XY\"", "MN+XY", &["subsets.among", "sensor `XY`", "known: "]),
    ("\"RN/2\"", "\"MN/0\"", "MN/0", &["subsets.among", "`MN/0`", "at least 1"]),
    ("like = \"attention\"", "learner = \"acl\"\nlike = \"foa\"", "among = [", &["subsets.among", "`RN/2`", "counterfactual"]),
    (FIXED, "like = \"foa\"\nlearner = \"sub\"\nbudget_of = [\"foa\"]", "\"sub\"", &["subsets.learner", "learner `sub`"]),
    ("[phase.foa]", "[phase.\"../../foa\"]", "[phase.demonstration]", &["phase: ", "`../../foa`", "letters, digits"]),
    ("[policy.blind]", "[policy.best_fixed]", "[policy.best_fixed]", &["policy.best_fixed", "kept for"]),
];

/// Sound values that do not go together.
#[rustfmt::skip]
pub const PARTS: &[Change] = &[
    ("sensing = \"everyone\"", "", "[phase.demonstration]", &["phase.demonstration.sensing", "nobody would learn", "everyone"]),
    ("acting = \"advisor\"", "acting = \"blind\"", "\"blind\"", &["phase.demonstration.acting", "only a policy"]),
    (
        "acting = { attention = \"acl_phase3\" }\nrate",
        "acting = { attention = \"acl_phase3\" }\nbootstrap = \"MN\"\nrate",
        "bootstrap = \"MN\"",
        &["phase.attention_phase3.bootstrap", "`MN` does not look before every move"],
    ),
    ("after = \"attention\"", "after = \"fusion\"", "after = \"fusion\"\nroster = [\"MN\", \"LN\", \"RN\", \"MF\", \"LF\", \"RF\", \"IR\"]\nacting = { attention = \"acl\" }\n\n[policy.acl_phase3]", &["policy.acl.after", "`acl` is not trained in phase `fusion`"]),
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
    ("[learner.tiny.mlp]", "[learner.tiny.given]", "learner = \"tiny\"", &["member.MN.learner", "one number per action"]),
    (
        "[learner.acl.mlp]",
        "[learner.acl.given]",
        "learner = \"acl\"\nsettings = { encoding = { content = \"support\"",
        &["attention.acl_decision.learner", "one number per action"],
    ),
    (
        SUBSETS,
        "[learner.spare.given]\n\n[subsets]\nlike = \"foa\"\nlearner = \"spare\"\nbudget_of = [\"foa\"]",
        "learner = \"spare\"",
        &["subsets.learner", "one number per action"],
    ),
];
