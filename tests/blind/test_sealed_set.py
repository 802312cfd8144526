"""A sealed case from drawing to score: the diagnosis runs as a process that sees logs and nominal values only."""

from pathlib import Path

from benchmarks.blind import answers, plan, score, seal


def test_the_diagnosis_names_the_effect_of_a_sealed_case(tmp_path: Path) -> None:
    folder = tmp_path / "set"
    fingerprint = plan.draw_set(folder, cases=1, seed=20261121, jobs=1, wish=plan.Wish(axes=("rigid_1m",)))
    found = answers.diagnose_set(folder, jobs=1, timeout=900)  # more is a hang
    assert seal.fingerprint(folder) == fingerprint
    assert [record["ended"] for record in found if record["answer"] is None] == []
    labels, given = seal.open_labels(folder), answers.read(folder)
    (verdict,) = (score.verdict(labels[case], given[case]) for case in labels)
    assert verdict.right or verdict.in_stated_set
