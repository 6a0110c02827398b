"""Writes deploy/advisories.toml as a copy of the list of RustSec that cargo-deny reads.

    deploy/advisories.py FOLDER    the copy, as a git repository

Fails if Cargo.lock has crates whose advisories were not read.
"""

import datetime
import pathlib
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
TEXTS = ("id", "package", "date", "informational", "withdrawn", "url")


def unread(crates: list[str]) -> list[str]:
    """Returns the crates of Cargo.lock from a registry that are not in the list."""
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())
    return sorted({p["name"] for p in lock["package"] if "source" in p} - set(crates))


def strings(values: list[str]) -> str:
    return "[" + ", ".join(f'"{v}"' for v in values) + "]"


def front_matter(advisory: dict) -> str:
    """Returns an advisory in the format of RustSec, with a link in place of its description."""
    lines = ["```toml", "[advisory]"]
    lines += [f'{key} = "{advisory[key]}"' for key in TEXTS if key in advisory]
    affected = {key: advisory.get(f"affected_{key}") for key in ("os", "arch")}
    if any(affected.values()):
        lines.append("[affected]")
        lines += [f"{key} = {strings(values)}" for key, values in affected.items() if values]
    lines += ["[versions]", f"patched = {strings(advisory['patched'])}"]
    if "unaffected" in advisory:
        lines.append(f"unaffected = {strings(advisory['unaffected'])}")
    name = advisory["id"]
    link = f"https://rustsec.org/advisories/{name}"
    return "\n".join([*lines, "```", "", f"# {name}", "", link, ""])


def main(folder: pathlib.Path) -> None:
    known = tomllib.loads((ROOT / "deploy/advisories.toml").read_text())
    if missing := unread(known["crates"]):
        sys.exit(
            "error: deploy/advisories.toml: the advisories of these crates were not read: "
            f"{', '.join(missing)}; read crates/NAME of https://github.com/rustsec/advisory-db, "
            "add what is there, and add the names to `crates`"
        )
    for advisory in known["advisory"]:
        place = folder / "crates" / advisory["package"]
        place.mkdir(parents=True, exist_ok=True)
        (place / f"{advisory['id']}.md").write_text(front_matter(advisory))
    author = ["-c", "user.name=crumple", "-c", "user.email=crumple@localhost"]
    git = ["git", "-C", str(folder), *author]
    subprocess.run([*git, "init", "--quiet"], check=True)
    subprocess.run([*git, "add", "--all"], check=True)
    subprocess.run([*git, "commit", "--quiet", "--message", "Known faults"], check=True)
    advisories, crates = (len(known[key]) for key in ("advisory", "crates"))
    if (days := (datetime.date.today() - known["until"]).days) > 90:
        print(f"warning: deploy/advisories.toml is {days} days old: read the list again")
    print(f"{advisories} advisories for {crates} crates, until {known['until']}")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
