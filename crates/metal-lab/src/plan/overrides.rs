//! `--set key=value`: one field of an experiment file, from the command line.

use super::error::PlanError;

/// Applies `assignments` (`phase.fusion.budget.episodes=100`) to a parsed file. Values are TOML; bare words are strings.
///
/// # Errors
/// If an assignment has no `=`, or leads through something that is not a table.
pub fn apply(table: &mut toml::Table, assignments: &[String]) -> Result<(), PlanError> {
    for assignment in assignments {
        let Some((path, value)) = assignment.split_once('=') else {
            return Err(PlanError::at(
                assignment.clone(),
                "--set wants key=value, e.g. phase.fusion.rate.constant=0.2",
            ));
        };
        assign(table, path.trim(), parse(value.trim()))?;
    }
    Ok(())
}

fn parse(value: &str) -> toml::Value {
    let wrapped = format!("v = {value}");
    let parsed = wrapped.parse::<toml::Table>().ok().and_then(|mut t| t.remove("v"));
    parsed.unwrap_or_else(|| toml::Value::String(value.to_owned()))
}

fn assign(table: &mut toml::Table, path: &str, value: toml::Value) -> Result<(), PlanError> {
    let mut at = table;
    let keys: Vec<&str> = path.split('.').collect();
    for key in &keys[..keys.len() - 1] {
        let next = at.entry((*key).to_owned()).or_insert_with(|| toml::Value::Table(toml::Table::new()));
        at = match next {
            toml::Value::Table(inner) => inner,
            other => {
                let message =
                    format!("--set cannot go into `{key}`: it is a {}, not a table", other.type_str());
                return Err(PlanError::at(path, message));
            }
        };
    }
    at.insert(keys[keys.len() - 1].to_owned(), value);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_typed_as_in_the_file() {
        let mut table: toml::Table = "[a.b]\nc = 1\n".parse().unwrap();
        let sets = ["a.b.c=2.5", "a.word=training", "a.list=[1, 2]", "new.key=true"].map(String::from);
        apply(&mut table, &sets).unwrap();
        let wanted: toml::Table =
            "a.b.c = 2.5\na.word = 'training'\na.list = [1, 2]\nnew.key = true\n".parse().unwrap();
        assert_eq!(table, wanted);
    }

    #[test]
    fn nonsense_is_refused_by_name() {
        let mut table: toml::Table = "a = 1".parse().unwrap();
        let error = apply(&mut table, &["a.b=2".into()]).unwrap_err().to_string();
        assert!(error.contains("a.b") && error.contains("integer"), "{error}");
        assert!(apply(&mut table, &["ab".into()]).is_err());
    }
}
