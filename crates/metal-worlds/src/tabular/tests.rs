use super::*;

fn small() -> Arc<Data> {
    let column = |name: &str, values: Vec<Option<f64>>| Column::new(name, values);
    let data = Data::new(
        "Small-v0",
        vec![
            column("a", vec![Some(0.0), None, Some(4.0)]),
            column("b", vec![Some(1.0), Some(1.0), Some(1.0)]),
        ],
        vec![Group { name: "both".into(), columns: vec![0, 1], price: 0.5 }],
        (vec!["no".into(), "yes".into()], vec![0, 1, 1]),
    );
    Arc::new(data.unwrap())
}

#[test]
fn an_absent_value_is_told_apart_from_every_number() {
    let mut world = Tabular::new(small(), Arc::new([1]), Verdict::default());
    let mut out = [f64::NAN; 3];
    world.sense(0, &mut out).unwrap();
    assert_eq!(out, [2.0, 0.0, 1.0], "the middle of 0 … 4, not known; b is never absent");
    let mut world = Tabular::new(small(), Arc::new([0]), Verdict::default());
    world.sense(0, &mut out).unwrap();
    assert_eq!(out, [0.0, 1.0, 1.0]);
}

#[test]
fn the_right_class_earns_and_the_wrong_one_costs() {
    let verdict = Verdict { right: 2.0, wrong: -3.0 };
    let mut world = Tabular::new(small(), Arc::new([2]), verdict);
    assert_eq!(world.advise(), Some(1));
    assert_eq!(world.step(1).unwrap(), Outcome { motor_reward: 2.0, end: End::Terminal });
    assert_eq!(world.step(0).unwrap().motor_reward, -3.0);
    assert_eq!(world.measures(), [0.0]);
}

#[test]
fn impossible_tables_are_refused_by_name() {
    let build = |columns: Vec<Column>, groups: Vec<Group>, labels: Vec<usize>| {
        Data::new("X-v0", columns, groups, (vec!["0".into(), "1".into()], labels)).unwrap_err().to_string()
    };
    let column = || Column::new("a", vec![Some(1.0), Some(2.0)]);
    let group = |price: f64| Group { name: "g".into(), columns: vec![0], price };
    assert!(build(vec![column()], vec![group(-1.0)], vec![0, 1]).contains("g"));
    assert!(build(vec![column()], vec![group(0.1)], vec![0]).contains("a"));
    assert!(build(vec![column()], vec![group(0.1)], vec![0, 2]).contains("label"));
    assert!(build(vec![column()], Vec::new(), vec![0, 1]).contains("group"));
    let stray = Group { name: "g".into(), columns: vec![1], price: 0.0 };
    assert!(build(vec![column()], vec![stray], vec![0, 1]).contains("column"));
    let empty = Column::new("a", vec![None, None]);
    assert!(build(vec![empty], vec![group(0.1)], vec![0, 1]).contains("a"));
}

/// Mean of a column over the rows of a class.
fn mean(data: &Data, column: usize, class: usize) -> f64 {
    let rows = (0..data.labels.len()).filter(|&r| data.labels[r] == class);
    let values: Vec<f64> = rows.filter_map(|r| data.columns[column].values[r]).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

#[test]
fn the_corners_of_the_cube_stand_where_the_class_says() {
    let data = cube(&CubeConfig { rows: 8000, ..CubeConfig::default() });
    assert_eq!((data.columns.len(), data.classes.len(), data.groups.len()), (20, 8, 20));
    // Class 3 is the corner (1, 1, 0) in columns 3, 4, 5; everywhere else it is noise around 0.5.
    let expected = [(3, 1.0), (4, 1.0), (5, 0.0), (2, 0.5), (6, 0.5), (19, 0.5)];
    for (column, wanted) in expected {
        let found = mean(&data, column, 3);
        assert!((found - wanted).abs() < 0.05, "column {column}: {found}");
    }
}

#[test]
fn the_context_says_which_block_holds_the_cube() {
    let data = cube_nm(&CubeNmConfig { rows: 8000, ..CubeNmConfig::default() });
    assert_eq!((data.columns.len(), data.groups.len()), (55, 51));
    assert_eq!(data.groups[0].columns.len(), 5, "the context is bought as a whole");
    let in_context = |row: usize, c: usize| data.columns[c].values[row].is_some_and(|x| x > 0.5);
    let rows: Vec<usize> = (0..8000).filter(|&r| in_context(r, 2) && data.labels[r] == 7).collect();
    let mean = |column: usize| {
        rows.iter().filter_map(|&r| data.columns[column].values[r]).sum::<f64>() / rows.len() as f64
    };
    // Class 7 is (1, 1, 1) at places 7, 8, 9 of the block of context 2, which begins at column 5 + 20.
    assert!(rows.len() > 100 && (mean(5 + 27) - 1.0).abs() < 0.1 && (mean(5 + 17) - 0.5).abs() < 0.1);
}
