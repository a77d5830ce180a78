"""Nothing that twistarm writes or serves tells where on the machine the arm lies, nor whose machine it is."""

from __future__ import annotations

from pathlib import Path

import pytest

from hostile.leaks import CANARY, inside, lay_arm
from twistarm import InputError, load_arm
from twistarm.cli.application import run
from twistarm.support.path_redaction import without_places

COMMANDS = {
    "page": "view ARM -o OUT/page.html",
    "motion": "plan ARM --to 0.1 0.2 --velocity 1 --acceleration 1 -o OUT/motion.csv -o OUT/motion.json",
    "golden": "freeze ARM -o OUT/golden.json",
    "baked": "bake ARM -o OUT/arm.json -o OUT/arm.hpp",
    "repaired": "doctor ARM --fix -o OUT/repaired.urdf",
    "draft": "init ARM -o BESIDE/arm.toml",
    "answers": "ik ARM --targets OUT/targets.csv -o OUT/answers.csv",
    "poses": "fk ARM --configurations OUT/postures.csv -o OUT/poses.csv",
    "info": "info ARM --json",
    "diagnosis": "doctor ARM --json",
    "check": "check ARM --json",
    "posture": "fk ARM --theta 0.1 0.2 --json",
}


@pytest.fixture
def arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = lay_arm(tmp_path.resolve())
    monkeypatch.setenv("HOME", str(path.parent.parent))
    for name in ("USER", "LOGNAME", "HOSTNAME"):
        monkeypatch.setenv(name, CANARY)
    out = tmp_path / "out"
    out.mkdir()
    (out / "targets.csv").write_text("x,y,z\n0.1,0.1,1.0\n9,9,9\n")
    (out / "postures.csv").write_text("a,b\n0.1,0.2\n")
    return path


@pytest.mark.parametrize("case", COMMANDS)
def test_what_is_written_tells_no_place(
    case: str, arm: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """From another folder, with the arm's whole path typed."""
    monkeypatch.chdir(tmp_path)
    places = {"ARM": str(arm), "OUT": "out", "BESIDE": str(arm.parent)}
    words = [word.replace("OUT", "out").replace("BESIDE", places["BESIDE"]) for word in COMMANDS[case].split()]
    code = run([places.get(word, word) for word in words])
    told = capfd.readouterr()
    assert code in (0, 1), told.err
    written = [arm.parent / "arm.toml"] if case == "draft" else [tmp_path / w for w in words if w.startswith("out/")]
    for data in [path.read_bytes() for path in written] + [told.out.encode()] * ("--json" in words):
        assert data
        leak = inside(data).lower()
        at = leak.find(CANARY.encode())
        assert at < 0, leak[max(0, at - 200) : at + 100]


def test_the_page_that_is_served_tells_no_place(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("meshcat")
    from twistarm.viewer.parts.findings import examined
    from twistarm.viewer.protocol.messages import failure

    loaded = load_arm(arm)
    assert any(CANARY in one.what for one in loaded.findings), "on the terminal a whole path helps"
    for one in examined(loaded)["findings"]:
        assert CANARY not in str(one)
    assert CANARY not in str(failure(InputError(f"cannot write {arm}")))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("cannot read /opt/my/arm.urdf: why", "cannot read arm.urdf: why"),
        ("file:///opt/my/m.stl, 'file://localhost/opt/my/m.stl'", "m.stl, 'm.stl'"),
        ("package://arm/meshes/m.stl and $(find arm)/urdf/x", "package://arm/meshes/m.stl and $(find arm)/urdf/x"),
        ("../a/b.stl, 2.5 rad/s/s, https://a.example/b/c", "../a/b.stl, 2.5 rad/s/s, https://a.example/b/c"),
        ("in HOME/with space/arm.urdf", "in with space/arm.urdf"),
        ("in HERE/m.stl (HERE)", "in m.stl ()"),
    ],
)
def test_a_path_is_told_by_its_name(text: str, told: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/no/such home")
    text = text.replace("HOME", "/no/such home").replace("HERE", "/other folder/my arm")
    assert without_places(text, Path("/other folder/my arm/arm.urdf")) == told


def test_texts_are_told_where_there_is_no_home_and_no_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    monkeypatch.setattr("os.path.expanduser", lambda path: path)  # as for a user of no name
    assert without_places("see /srv/arms/a.urdf") == "see a.urdf"
