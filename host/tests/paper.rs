//! Tests of `arboleda paper`: its files, and what its page says.

use std::collections::HashMap;
use std::fs;

use arboleda_host::benchmark::harness::summary::gain_percent;
use arboleda_host::benchmark::studies::paper::printed::PRINTED;
use arboleda_host::benchmark::studies::paper::protocol::LEAF_CAPACITIES;

mod program;

use program::{failure, folder, names, run_in, success};

const COLUMNS: [&str; 14] = [
    "scene",
    "level",
    "leaf_capacity",
    "grid",
    "octree_us_per_photon",
    "grid_us_per_photon",
    "gain_percent",
    "paper_gain_percent",
    "octree_nodes",
    "octree_tests",
    "grid_nodes",
    "grid_tests",
    "octree_bytes",
    "grid_bytes",
];

#[test]
fn a_quick_run_writes_the_tables_and_the_page() {
    let folder = folder();
    let arguments = ["paper", "--quick", "--scenes", "fig4d,fig4a", "--out", "out"];
    let (shown, _) = success(&run_in(folder.path(), &arguments));
    assert!(shown.contains("best against best") && shown.contains("fig4d"), "{shown}");
    let out = folder.path().join("out");
    let pictures = ["fig2.png", "fig3.png", "fig4a.png", "fig4d.png"];
    let files = pictures.into_iter().chain(["index.html", "paper.csv", "tables.csv"]);
    assert_eq!(names(&out), files.collect::<Vec<_>>());

    // 1. The file: the columns, and a line for each scene, level and leaf capacity that the paper prints.
    let mut file = csv::Reader::from_path(out.join("tables.csv")).unwrap();
    assert_eq!(file.headers().unwrap().iter().collect::<Vec<_>>(), COLUMNS);
    let lines: Vec<HashMap<String, String>> = file.deserialize().collect::<Result<_, _>>().unwrap();
    let asked = PRINTED.iter().filter(|table| ["fig4a", "fig4d"].contains(&table.scene));
    let expected = asked.flat_map(|table| {
        let rows = table.rows.iter().map(move |row| (table.scene, row));
        rows.flat_map(|(scene, row)| LEAF_CAPACITIES.map(|capacity| (scene, row, capacity)))
    });
    let expected: Vec<_> = expected.collect();
    assert_eq!(lines.len(), expected.len());
    for (line, (scene, row, capacity)) in lines.iter().zip(expected) {
        let number = |column: &str| line[column].parse::<f64>().unwrap();
        assert_eq!(line["scene"], scene);
        let found = ["level", "leaf_capacity", "grid"].map(number);
        assert_eq!(found, [row.level, capacity, row.grid].map(f64::from));
        assert_eq!(number("paper_gain_percent"), row.gain_percent);
        let gain = gain_percent(number("octree_us_per_photon"), number("grid_us_per_photon"));
        assert!((number("gain_percent") - gain).abs() < 1e-9, "{line:?}");
        for column in &COLUMNS[8..] {
            assert!(number(column) > 0.0, "{column}: {line:?}");
        }
    }

    // 2. The higher the level, the fewer tests.
    let tests = |capacity: &str| -> Vec<f64> {
        let lines = lines
            .iter()
            .filter(|line| line["scene"] == "fig4d" && line["leaf_capacity"] == capacity);
        lines.map(|line| line["octree_tests"].parse().unwrap()).collect()
    };
    for capacity in ["1", "12"] {
        assert!(tests(capacity).is_sorted_by(|a, b| a >= b), "{:?}", tests(capacity));
    }

    // 3. The page.
    let page = fs::read_to_string(out.join("index.html")).unwrap();
    for part in [
        "Tables 1 to 3, as printed",
        "Figure 4(a): gain against level",
        "Figure 4(d), 5 clusters: times and gains",
        "Figure 4(d): counters",
        "2727.17",
        "why rows differ",
        "as the clusters move apart",
        "arboleda paper --quick --scenes fig4d,fig4a",
    ] {
        assert!(page.contains(part), "{part}");
    }
    assert!(!page.contains("NaN") && !page.contains("Figure 4(b)"));

    // 4. The pictures are those of the command below them.
    assert_eq!(page.matches("data:image/png;base64,").count(), pictures.len());
    for scene in ["fig3", "fig4a"] {
        let command = page.split(&format!("arboleda render --scene {scene}")).nth(1).unwrap();
        let command = command.split('<').next().unwrap();
        let command = format!("render --scene {scene}{command}");
        let command = command.split('"').next().unwrap();
        success(&run_in(folder.path(), &command.split_whitespace().collect::<Vec<_>>()));
        let file = format!("{scene}.png");
        let [made, shown] = [folder.path().join(&file), out.join(&file)].map(fs::read);
        assert!(made.unwrap() == shown.unwrap(), "{command}");
    }
}

#[test]
fn scenes_that_are_not_in_the_tables_are_refused() {
    let folder = folder();
    let said = failure(&run_in(folder.path(), &["paper", "--scenes", "fig3"]));
    assert!(said.contains("fig4a") && said.contains("'fig3'"), "{said}");
    let said = failure(&run_in(folder.path(), &["paper", "--quick", "--photons", "5"]));
    assert!(said.contains("cannot be used with"), "{said}");
    assert!(names(folder.path()).is_empty());
}
