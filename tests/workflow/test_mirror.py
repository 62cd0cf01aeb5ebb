"""Results on a store that speaks S3: a copy that each run brings up to date, and from which another machine goes on."""

import json
import shutil
import time
from collections.abc import Iterator
from pathlib import Path

import fsspec
import pytest
from fsspec.implementations.local import LocalFileSystem

from drillid.errors import SettingsError
from drillid.fleet import mirror_lock
from drillid.fleet.command import OUTCOME
from drillid.fleet.crate import CRATE
from drillid.fleet.manifest import KEY
from drillid.fleet.mirror import Changes, hold_mirror, restore, update_mirror
from tests.s3 import BUCKET, store
from tests.workflow.killed import digests
from tests.workflow.toys import Checkout, jobs_in

PLACE = f"{BUCKET}/fleets/main"
MIRROR = f"s3://{PLACE}"


@pytest.fixture
def bucket(monkeypatch: pytest.MonkeyPatch) -> Iterator[fsspec.AbstractFileSystem]:
    with store() as environment:
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        yield fsspec.filesystem("s3", skip_instance_cache=True, use_listings_cache=False)


def there(bucket: fsspec.AbstractFileSystem) -> dict[str, str]:
    """Tags of the copy's objects, which change whenever one is written with another content."""
    return {
        name.removeprefix(f"{PLACE}/"): file["LastModified"] for name, file in bucket.find(PLACE, detail=True).items()
    }


def test_a_run_keeps_a_copy_on_s3_from_which_another_machine_goes_on(
    finished: Checkout, bucket: fsspec.AbstractFileSystem
) -> None:
    words = ("--config", f"mirror={MIRROR}")
    results = finished.root / "results/main"
    assert finished.would_run(*words) == ["mirror", "all"]
    finished.run(*words)
    expected = digests(results)
    assert {name for name in there(bucket) if not Path(name).name.startswith(".")} == {*expected, CRATE}
    assert "Nothing to be done" in finished.run(*words)
    # a machine that has nothing but the checkout
    shutil.rmtree(results)
    shutil.rmtree(finished.root / ".snakemake")
    finished.journal()
    assert "was fetched from" in finished.run(*words)
    assert finished.journal() == []
    assert digests(results) == expected
    before = there(bucket)
    (finished.root / "raw/c.csv").write_text("other samples")
    finished.run(*words)
    assert {line.split()[1] for line in finished.journal()} == {"W-2"}
    written = {name for name, time in there(bucket).items() if before.get(name) != time}
    assert f"records/W-2/{KEY}" in written
    assert not [name for name in written if "/W1/" in name]
    assert mirror_lock.LOCK not in there(bucket)


@pytest.fixture
def results(tmp_path: Path) -> Path:
    folder = tmp_path / "main"
    for well in ("W1", "W2"):
        (folder / "fits" / well / "fits.zarr").mkdir(parents=True)
        (folder / "fits" / well / "fits.zarr/zarr.json").write_text("{}")
        (folder / "fits" / well / KEY).write_text(f'{{"key": "{well}"}}')
        (folder / f"fits/{well}.json").write_text("{}")
    (folder / "report.html").write_text("report")
    (folder / "fits/.previous").mkdir()
    (folder / "fits/.previous/old").write_text("old")
    return folder


@pytest.mark.parametrize("on_s3", [True, False])
def test_only_what_has_changed_is_written_and_what_is_gone_goes(
    results: Path, bucket: fsspec.AbstractFileSystem, tmp_path: Path, on_s3: bool
) -> None:
    mirror = MIRROR if on_s3 else str(tmp_path / "share/main")
    update = lambda: update_mirror(results, mirror, results / "mirror.json")  # noqa: E731
    assert update() == Changes(7, 0)
    assert update() == Changes(0, 0)
    (results / "fits/W1/fits.zarr/zarr.json").write_text('{"a": 1}')
    (results / "fits/W2/fits.zarr/zarr.json").unlink()
    assert update() == Changes(1, 1)
    copy = tmp_path / "other/main"
    assert restore(copy, mirror)
    (results / "fits/.previous/old").unlink()
    assert digests(copy) == digests(results)
    assert (copy / "report.html").stat().st_mtime_ns == (results / "report.html").stat().st_mtime_ns
    assert not restore(copy, mirror)


def test_a_folder_has_no_key_in_the_copy_while_it_is_brought_up_to_date(
    results: Path, bucket: fsspec.AbstractFileSystem, monkeypatch: pytest.MonkeyPatch
) -> None:
    update_mirror(results, MIRROR, results / "mirror.json")
    (results / "fits/W1/fits.zarr/zarr.json").write_text('{"a": 1}')

    async def failing(*_: object, **__: object) -> None:
        raise OSError("the connection is lost")

    with monkeypatch.context() as patch:
        patch.setattr(type(bucket), "_put_file", failing)
        with pytest.raises(SettingsError, match="the connection is lost"):
            update_mirror(results, MIRROR, results / "mirror.json")
    assert f"fits/W1/{KEY}" not in there(bucket)
    assert f"fits/W2/{KEY}" in there(bucket)
    update_mirror(results, MIRROR, results / "mirror.json")
    assert f"fits/W1/{KEY}" in there(bucket)


@pytest.mark.parametrize("on_s3", [True, False])
def test_another_machine_waits_until_the_first_is_done_or_gone(
    results: Path, bucket: fsspec.AbstractFileSystem, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, on_s3: bool
) -> None:
    mirror, other = MIRROR if on_s3 else str(tmp_path / "share/main"), tmp_path / "other/main"
    release = hold_mirror(results, mirror)
    with pytest.raises(SettingsError, match=f"another machine works on the copy .*{results}"):
        hold_mirror(other, mirror)
    # a run that was killed is taken up by the next on the same results
    again = hold_mirror(results, mirror)
    release()
    with pytest.raises(SettingsError, match="another machine works on the copy"):
        hold_mirror(other, mirror)
    again()
    hold_mirror(other, mirror)()
    hold_mirror(results, mirror)
    now = time.time()
    monkeypatch.setattr(mirror_lock.time, "time", lambda: now + 1000.0)
    hold_mirror(other, mirror)()


def test_a_dry_run_and_a_run_that_another_machine_keeps_away_fetch_nothing(
    finished: Checkout, monkeypatch: pytest.MonkeyPatch
) -> None:
    share, results = finished.root / "share", finished.root / "results/main"
    words = ("--config", f"mirror={share}")
    finished.run(*words)
    results.rename(finished.root / "elsewhere")
    output = finished.run("--dry-run", *words)
    assert f"results/main is not there; a run begins with its copy in {share}" in output
    assert "records W1" in jobs_in(output)
    assert not results.exists()
    finished.run("--summary", *words)
    assert not results.exists()
    release = hold_mirror(finished.root / "elsewhere", str(share))
    with monkeypatch.context() as told:
        told.setenv(OUTCOME, str(finished.root / "outcome.json"))
        assert "another machine works on the copy" in finished.run(*words, expect=1)
    outcome = json.loads((finished.root / "outcome.json").read_text())
    assert outcome["line"].startswith("Nothing was done: mirror: another machine works on the copy")
    assert not results.exists()
    release()
    finished.journal()
    assert "was fetched from" in finished.run(*words)
    assert finished.journal() == []


def test_a_run_that_another_machine_keeps_away_leaves_the_results_as_they_were(finished: Checkout) -> None:
    results, words = finished.root / "results/main", ("--config", f"mirror={finished.root / 'share'}")
    finished.run(*words)
    shutil.rmtree(results / "spectra/W1")
    before = files_in(results)
    release = mirror_lock.hold(LocalFileSystem(), str(finished.root / "share"), finished.root / "elsewhere")
    assert "another machine works on the copy" in finished.run(*words, expect=1)
    assert files_in(results) == before
    release()
    finished.journal()
    finished.run(*words)
    assert finished.journal() == ["spectra W1"]


def files_in(results: Path) -> dict[str, tuple[int, bytes]]:
    """Time and content of everything in the results but the lock."""
    files = [path for path in sorted(results.rglob("*")) if path.is_file() and path.name != ".lock"]
    return {str(path): (path.stat().st_mtime_ns, path.read_bytes()) for path in files}


def test_results_that_do_not_go_on_from_the_copy_never_overwrite_it(results: Path, tmp_path: Path) -> None:
    mirror, other = str(tmp_path / "share/main"), tmp_path / "other/main"
    update_mirror(results, mirror, results / "mirror.json")
    restore(other, mirror)
    (other / "fits/W1/fits.zarr/zarr.json").write_text('{"a": 1}')
    assert update_mirror(other, mirror, other / "mirror.json") == Changes(1, 0)
    for refused in (
        lambda: update_mirror(results, mirror, results / "mirror.json"),
        lambda: hold_mirror(results, mirror),
    ):
        with pytest.raises(SettingsError, match=f"{results} does not continue from that. Move {results} away"):
            refused()
    hold_mirror(other, mirror)()
    assert update_mirror(other, mirror, other / "mirror.json") == Changes(0, 0)


def test_a_bucket_that_is_not_there_is_named(results: Path, bucket: fsspec.AbstractFileSystem) -> None:
    with pytest.raises(SettingsError, match="s3://nowhere/main cannot be reached or written"):
        update_mirror(results, "s3://nowhere/main", results / "mirror.json")


def test_what_others_keep_in_a_place_is_never_deleted(results: Path, tmp_path: Path) -> None:
    share = tmp_path / "share"
    (share / "other project").mkdir(parents=True)
    (share / "other project/thesis.docx").write_text("precious")
    (share / mirror_lock.LOCK).write_text("a lock of something else")
    before = digests(share)
    for refused in (
        lambda: update_mirror(results, str(share), results / "mirror.json"),
        lambda: hold_mirror(results, str(share)),
    ):
        with pytest.raises(SettingsError, match=r"share holds files, but no copy of results\. Name an empty folder"):
            refused()
    assert digests(share) == before
    assert (share / mirror_lock.LOCK).read_text() == "a lock of something else"
    shutil.rmtree(share)
    share.mkdir()
    update_mirror(results, str(share), results / "mirror.json")
    (share / "fits/W1/notes.txt").write_text("of a colleague")
    shutil.rmtree(results / "fits/W1")
    assert update_mirror(results, str(share), results / "mirror.json") == Changes(0, 2)
    assert [path.name for path in (share / "fits/W1").rglob("*") if path.is_file()] == ["notes.txt"]


def test_a_bucket_with_other_objects_is_left_alone(results: Path, bucket: fsspec.AbstractFileSystem) -> None:
    bucket.pipe_file(f"{BUCKET}/thesis.docx", b"precious")
    with pytest.raises(SettingsError, match=f"s3://{BUCKET} holds files, but no copy of results"):
        update_mirror(results, f"s3://{BUCKET}", results / "mirror.json")
    # beside them there may be a copy
    assert update_mirror(results, MIRROR, results / "mirror.json") == Changes(7, 0)
    assert bucket.cat_file(f"{BUCKET}/thesis.docx") == b"precious"


@pytest.mark.parametrize("place", ["main", "main/copy", ".", "link"])
def test_a_copy_is_apart_from_the_results(results: Path, tmp_path: Path, place: str) -> None:
    (tmp_path / "link").symlink_to(results)
    before = digests(tmp_path)
    for refused in (
        lambda: update_mirror(results, str(tmp_path / place), results / "mirror.json"),
        lambda: hold_mirror(results, str(tmp_path / place)),
    ):
        with pytest.raises(SettingsError, match=f"and the results in {results} lie in one another"):
            refused()
    assert digests(tmp_path) == before


def test_a_copy_of_an_earlier_version_is_recognised(results: Path, tmp_path: Path) -> None:
    share = tmp_path / "share"
    update_mirror(results, str(share), results / "mirror.json")
    listing = json.loads((share / "mirror.json").read_text())
    (share / "mirror.json").write_text(json.dumps({name: listing[name] for name in ("mirror", "files")}))
    (results / ".mirror").unlink()
    hold_mirror(results, str(share))()
    (results / "fits/W2.json").unlink()
    assert update_mirror(results, str(share), results / "mirror.json") == Changes(0, 1)


def test_a_copy_whose_listing_was_cut_off_is_written_anew(results: Path, tmp_path: Path) -> None:
    share = tmp_path / "share"
    update_mirror(results, str(share), results / "mirror.json")
    (share / "mirror.json").write_text('{"mirror": "')
    assert update_mirror(results, str(share), results / "mirror.json") == Changes(7, 0)
    assert restore(tmp_path / "other/main", str(share))


@pytest.mark.parametrize("well", ["raw", "logs", "benchmarks", "W.part"])
def test_wells_of_any_name_are_copied(results: Path, tmp_path: Path, well: str) -> None:
    for name in ("raw", "logs", "benchmarks", "fleet.part"):
        (results / name).mkdir()
        (results / name / "a.log").write_text("of this machine alone")
    (results / "fits/W1/fits.part").mkdir()
    (results / "fits/W1/fits.part/zarr.json").write_text("half written")
    (results / "fits/W1").rename(results / "fits" / well)
    share = tmp_path / "share"
    assert update_mirror(results, str(share), results / "mirror.json") == Changes(7, 0)
    assert (share / "fits" / well / KEY).exists()


def test_an_update_that_was_killed_leaves_a_copy_of_what_is_whole(
    results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    share, other, data = tmp_path / "share", tmp_path / "other/main", results / "fits/W1/fits.zarr/zarr.json"
    update_mirror(results, str(share), results / "mirror.json")
    data.write_text('{"a": 1}')
    data.with_name("later").write_text("gone before the next run")
    put = LocalFileSystem.put

    def killed_before_keys(system: LocalFileSystem, files: list[str], *words: object) -> None:
        if any(Path(name).name == KEY for name in files):
            raise OSError("the machine died")
        put(system, files, *words)

    with monkeypatch.context() as patch:
        patch.setattr(LocalFileSystem, "put", killed_before_keys)
        with pytest.raises(SettingsError, match="the machine died"):
            update_mirror(results, str(share), results / "mirror.json")
    assert restore(other, str(share))
    assert [path.parent.name for path in other.rglob(KEY)] == ["W2"]
    # without manifests, tables and report the next run makes sure of everything
    assert {path.relative_to(other).parts[0] for path in other.rglob("*")} == {"fits", "mirror.json", ".mirror"}
    data.with_name("later").unlink()
    update_mirror(results, str(share), results / "mirror.json")
    shutil.rmtree(results / "fits/.previous")
    assert digests(share) == digests(results)
