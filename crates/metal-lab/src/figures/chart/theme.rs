//! The colours, once for light and once for dark. Categories follow Okabe and Ito, who chose them so that people with
//! any kind of colour vision can tell them apart.

/// CSS variables for light pages and for print: name and colour.
pub const LIGHT: &[(&str, &str)] = &[
    ("page", "#ffffff"),
    ("panel", "#f6f7f9"),
    ("text", "#1c2128"),
    ("muted", "#5b6470"),
    ("grid", "#e1e5ea"),
    ("link", "#0061a8"),
    ("good", "#00704f"),
    ("bad", "#b34700"),
    ("foa", "#33383f"),
    ("fusion", "#d55e00"),
    ("fusion-pool", "#e69f00"),
    ("acl", "#0072b2"),
    ("acl-phase3", "#6f9bc8"),
    ("acl-decision", "#004c80"),
    ("acl-paper", "#56b4e9"),
    ("foa-paper", "#7f7f7f"),
    ("fixed", "#009e73"),
    ("random", "#8a929c"),
    ("blind", "#b4bac2"),
    ("oracle", "#cc79a7"),
    ("look0", "#cdd6e0"),
    ("look1", "#fde725"),
    ("look2", "#8fd744"),
    ("look3", "#35b779"),
    ("look4", "#21908d"),
    ("look5", "#31688e"),
    ("look6", "#443a83"),
    ("look7", "#440154"),
    ("mn", "#0072b2"),
    ("ln", "#56b4e9"),
    ("rn", "#009e73"),
    ("mf", "#d55e00"),
    ("lf", "#e69f00"),
    ("rf", "#cc79a7"),
    ("ir", "#33383f"),
    ("none", "#b4bac2"),
    ("road", "#d8dce2"),
    ("car", "#d7301f"),
];

/// CSS variables for dark pages; those not named here are as in [`LIGHT`].
pub const DARK: &[(&str, &str)] = &[
    ("page", "#14181d"),
    ("panel", "#1c2229"),
    ("text", "#e6e9ed"),
    ("muted", "#9aa5b1"),
    ("grid", "#2e363f"),
    ("link", "#6cb6ff"),
    ("good", "#3fc99a"),
    ("bad", "#ff9f5a"),
    ("foa", "#d3d9e0"),
    ("fusion", "#ef7a26"),
    ("acl", "#3b9ee0"),
    ("acl-phase3", "#a9c7e6"),
    ("acl-decision", "#4f9fd6"),
    ("acl-paper", "#9ad2f5"),
    ("foa-paper", "#b0b0b0"),
    ("fixed", "#20bd8f"),
    ("random", "#8a94a0"),
    ("blind", "#5e6873"),
    ("look0", "#59636e"),
    ("look6", "#5a4fa8"),
    ("look7", "#7d2b8f"),
    ("mn", "#3b9ee0"),
    ("ln", "#9ad2f5"),
    ("rn", "#20bd8f"),
    ("mf", "#ef7a26"),
    ("ir", "#d3d9e0"),
    ("none", "#5e6873"),
    ("road", "#343c46"),
    ("car", "#ff5a47"),
];

/// Colours of the camera's classes: a picture looks the same on every page.
const PIXELS: &[(&str, &str)] = &[
    ("px-road", "#2b2e33"),
    ("px-line", "#f4f4f0"),
    ("px-car", "#d7301f"),
    ("px-side", "#4f9d55"),
    ("px-sky", "#cfe0ee"),
    ("px-mark", "#f0e442"),
    ("px-shade", "#0b0e12"),
];

/// The rules that make a drawing follow the theme: variables, the sizes of text, and the switch to dark.
///
/// `root` is the selector that carries the variables: `:root` in a page, `svg.chart` in a file of its own.
#[must_use]
pub fn variables(root: &str) -> String {
    let list = |colours: &[(&str, &str)]| -> String {
        colours.iter().map(|(name, colour)| format!("--{name}:{colour};")).collect()
    };
    let (light, dark, pixels) = (list(LIGHT), list(DARK), list(PIXELS));
    format!(
        "{root}{{color-scheme:light dark;{light}{pixels}}}\n\
         @media screen and (prefers-color-scheme:dark){{{root}:not([data-theme=light]){{{dark}}}}}\n\
         @media screen{{{root}[data-theme=dark]{{color-scheme:dark;{dark}}}}}\n\
         {TEXT}"
    )
}

const TEXT: &str = "svg.chart{font-family:system-ui,-apple-system,\"Segoe UI\",\"Helvetica Neue\",Arial,sans-serif}\
svg.chart text{fill:var(--text);font-size:12px}\
svg.chart .title{font-size:14px;font-weight:600}\
svg.chart .label,svg.chart .tick,svg.chart .small{fill:var(--muted)}\
svg.chart .tick,svg.chart .value{font-variant-numeric:tabular-nums}\
svg.chart .small{font-size:11px}\
svg.chart .value{font-weight:600}\
svg.chart .badge{fill:#000;font-weight:700}\
svg.chart .onpicture{fill:#fff;font-weight:600;paint-order:stroke;stroke:#000;stroke-width:3px}\n";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dark_theme_only_repaints_what_the_light_one_names() {
        for (name, _) in DARK {
            assert!(LIGHT.iter().any(|(light, _)| light == name), "--{name}");
        }
    }
}
