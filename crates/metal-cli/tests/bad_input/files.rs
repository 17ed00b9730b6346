//! Bad files of every kind, and a good run folder to spoil.

use std::path::Path;

/// The toy in a few lines of its own, to be spoilt one line at a time.
const TOY: &str = include_str!("../../../../experiments/toy.toml");

/// The same toy, whose attention is learned by counterfactual policy iteration.
const ROLLED: &str = include_str!("../../../../experiments/toy_counterfactual.toml");

/// File → text.
const TEXTS: &[(&str, &str)] = &[
    ("empty.toml", ""),
    ("garbage.toml", "\u{1}\u{2} = ]["),
    ("half.toml", "title = \"half\n"),
    ("other.toml", "[package]\nname = \"x\"\n"),
    ("rows.csv", "a,b,ill\n1,2,0\n2,3,1\n3,NA,0\n4,1,1\n5,2,0\n6,2,1\n7,1,0\n8,1,1\n"),
    ("empty.csv", ""),
    ("header.csv", "a,b,ill\n"),
    ("ragged.csv", "a,b,ill\n1,2,0\n1,2\n"),
    ("twice.csv", "a,a,ill\n1,2,0\n2,3,1\n"),
    ("one-class.csv", "a,ill\n1,0\n2,0\n3,0\n4,0\n"),
    ("alone.csv", "ill\n0\n1\n"),
    ("infinite.csv", "a,ill\n1e999,0\n2,1\n3,0\n4,1\n"),
    ("negative.toml", "default = -1.0\n"),
    ("unknown.toml", "defualt = 1.0\n"),
    ("nobody.toml", "[group.x]\ncolumns = [\"z\"]\nprice = 1.0\n"),
    ("all.toml", "test_share = 1.0\n"),
    ("word.toml", "default = \"cheap\"\n"),
    ("empty.jsonl", ""),
    ("garbage.jsonl", "not json\n"),
    (
        "old.jsonl",
        "{\"metal_demonstrations\":9,\"environment\":\"Highway-v0\",\"sensors\":[],\"actions\":[],\"made_with\":\"x\"}\n",
    ),
    (
        "strange.jsonl",
        "{\"metal_demonstrations\":1,\"environment\":\"Moon-v0\",\"sensors\":[],\"actions\":[\"fly\"],\"made_with\":\"x\"}\n",
    ),
    ("no.mcap", "not a recording"),
    ("calibration.toml", "colours = 7\n"),
    ("file", "in the way"),
    ("taken/run.json", "{}"),
    ("damaged/run.json", "{"),
    ("damaged/plan.toml", TOY),
    ("lonely/run.json", "{}"),
    ("many/run.json", "{\"version\":\"0.1.0\",\"seed\":1,\"seeds\":99999999,\"blind\":0,\"quick\":false}"),
    ("many/plan.toml", TOY),
    ("blind/run.json", "{\"version\":\"0.1.0\",\"seed\":1,\"seeds\":1,\"blind\":9,\"quick\":false}"),
    ("blind/plan.toml", TOY),
    ("mindless/run.json", "{\"version\":\"0.1.0\",\"seed\":1,\"seeds\":1,\"blind\":0,\"quick\":false}"),
    ("mindless/plan.toml", TOY),
    ("forged/run.json", "{\"version\":\"0.1.0\",\"seed\":1,\"seeds\":1,\"blind\":0,\"quick\":false}"),
    ("forged/plan.toml", TOY),
    ("forged/minds/seed-0/attention.mind", "#!/bin/sh\necho no\n"),
    ("cut/run.json", "{\"version\":\"0.1.0\",\"seed\":1,\"seeds\":1,\"blind\":0,\"quick\":false}"),
    ("cut/plan.toml", TOY),
    ("cut/minds/seed-0/attention.mind", "METALMND\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}\u{1}"),
    ("rolled/run.json", "{\"version\":\"0.1.0\",\"seed\":1,\"seeds\":1,\"blind\":0,\"quick\":false}"),
    ("rolled/plan.toml", ROLLED),
    ("stopped/checkpoint/job.toml", "format = 1\n"),
];

/// File, what stands in the toy, what stands there instead.
const CHANGES: &[(&str, &str, &str)] = &[
    ("key.toml", "runs = 20000", "rums = 20000"),
    ("type.toml", "runs = 20000", "runs = \"many\""),
    ("zero.toml", "runs = 20000", "runs = 0"),
    ("sensor.toml", "sensors = [\"MN\"]", "sensors = [\"ZZ\"]"),
    ("learner.toml", "learner = \"acl\"", "learner = \"nobody\""),
    ("budget.toml", "budget = { episodes = 10000 }", "budget = { episodes = -3 }"),
    ("after.toml", "after = \"attention\"", "after = \"yesterday\""),
    ("world.toml", "[environment.toy]", "[environment.moon]"),
    ("fuser.toml", "fusion = \"log_opinion_pool\"", "fusion = \"magic\""),
    ("rate.toml", "rate = { constant = 0.05 }\nexploration", "rate = { constant = 5.0 }\nexploration"),
    ("roster.toml", "roster = [\"MN\", \"MF\"", "roster = [\"MN\", \"MN\""),
    ("title.toml", "title =", "titel ="),
];

pub fn write(folder: &Path) {
    let put = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    };
    for (name, text) in TEXTS {
        put(name, text.as_bytes());
    }
    for (name, old, new) in CHANGES {
        assert!(TOY.contains(old), "{old} is not in toy.toml any more");
        put(name, TOY.replacen(old, new, 1).as_bytes());
    }
    put("toy.toml", TOY.as_bytes());
    put("latin.toml", b"title = \"caf\xe9\"\n");
    put("latin.csv", b"a,ill\ncaf\xe9,0\nb,1\n");
}
