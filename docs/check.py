#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Are the documents true to the code, as far as a script can tell?

docs/check.py            every constant of calibration/, diagnosis/, earth/ and recording/ stands in
                         docs/thresholds.md with its value, or among those that decide nothing; so
                         does every bare number in a comparison there, and every number that an
                         options struct begins with; every
                         name "`name` in `file`" is in that file; every file that a document or a
                         comment names is there (a header in a comment by the end of its path); no
                         section that a document or a comment cites is there; every file that lowers
                         a verdict is in docs/theory.md, "The verdict"; no
                         room includes another one than the table of docs/design.md says; no folder
                         has more than 30 sources (but bench/ and tests/); every file of tests is
                         in a target
docs/check.py --rooms    prints the rooms of docs/design.md with their files and lines
docs/check.py --values   brings docs/thresholds.md up to the code: values anew, rows of constants that
                         are gone taken out, new ones under "Not described yet" with their comment,
                         for you to move to their place and to say what they decide

Needs nothing but Python's own library. Exit code 1 with one line for each fault.
"""

import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
ROOMS = ("apps/", "archive/", "calibration/", "diagnosis/", "earth/", "navigation/", "recording/")
# Of these the bare numbers, too; readers of formats have many, and rivals are as published.
JUDGES = ("calibration/beginning", "calibration/fit/", "calibration/live/", "calibration/motion/",
          "calibration/pipeline", "calibration/scan/", "calibration/start/", "calibration/survey/",
          "calibration/trust/", "calibration/turning", "calibration/use/", "diagnosis/",
          "recording/checks/", "recording/data/", "recording/live/", "recording/oddities/")
THRESHOLDS = ROOT / "docs/thresholds.md"
NUMBER = re.compile(
    r"(double|float|int|long|bool|unsigned( \w+)?|std::(size_t|ptrdiff_t|u?int\d+_t)"
    r"|std::array<double, ?\d+>|std::array<int, ?\d+>|Eigen::Index|NoiseDensities|Drift)"
)
DECLARATION = re.compile(r"\bconstexpr\s+(?P<type>[\w:<>, *]+?)\s*\b(?P<rest>k[A-Z]\w*\s*[\[={][^;]*);")
FOREIGN = r"AP_|LogStructure\.h|src/lib/"  # ArduPilot's and PX4's sources, which comments cite
SOURCES = (".h", ".cpp", ".inc")
MOST_FILES = 30  # of a folder; more have no overview
UNCUT = ("bench", "tests")
BARE = "Numbers without a name"  # the heading over those
DRAWN = "These decide nothing"  # the heading behind which the exceptions stand


def tracked():
    # Before a commit, too.
    names = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, check=True,
                           capture_output=True, text=True).stdout
    return [name for name in names.splitlines() if (ROOT / name).is_file()]


def without_comments(text):
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S)


def at_top_level(text):
    """Splits at commas that stand in no bracket."""
    out, depth = [""], 0
    for c in text:
        depth += (c in "([{") - (c in ")]}")
        if c == "," and depth == 0:
            out.append("")
        else:
            out[-1] += c
    return [part.strip() for part in out]


def constants_of(text):
    """(name, initializer) of every number that is a constexpr called k..."""
    for match in DECLARATION.finditer(without_comments(text)):
        if not NUMBER.fullmatch(match["type"].strip()):
            continue
        for part in at_top_level(match["rest"]):
            found = re.match(r"(k[A-Z]\w*)\s*(?:\[[^\]]*\]\s*)*=?\s*(.*)", part, re.S)
            if found:
                yield found[1], " ".join(found[2].split())


def code_constants(files):
    out = {}
    for file in files:
        if file.startswith(ROOMS) and file.endswith((".h", ".cpp", ".inc")):
            for name, value in constants_of((ROOT / file).read_text()):
                out.setdefault((file, name), []).append(value)
    return {key: "; ".join(dict.fromkeys(values)) for key, values in out.items()}


def names_in(cell):
    return re.findall(r"\bk[A-Z]\w*", cell)


def table(lines):
    """(line number, file, names, cells) of every row about constants; cells is empty for those that
    decide nothing."""
    file, nothing = "", False
    for number, line in enumerate(lines):
        if line.startswith("#"):
            nothing = nothing or DRAWN in line
            heading = re.fullmatch(r"#+ `([\w/.]+)`", line)
            file = heading[1] if heading else ""
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|") or len(cells) < 3 or set(line) <= set("|- "):
            continue
        if nothing and cells[0].startswith("`"):
            yield number, cells[0].strip("`"), names_in(cells[1]), []
        elif not nothing and file and cells[0].startswith("k"):
            yield number, file, names_in(cells[0]), cells


def value_cell(code, file, names):
    return "; ".join(code.get((file, name), "?") for name in names).replace("|", "\\|")


def check_thresholds(files):
    faults, seen = [], set()
    code = code_constants(files)
    for number, file, names, cells in table(THRESHOLDS.read_text().split("\n")):
        where = f"docs/thresholds.md:{number + 1}"
        for name in names:
            if (file, name) not in code:
                faults.append(f"{where}: there is no constant {name} in {file}; docs/check.py --values")
            elif (file, name) in seen:
                faults.append(f"{where}: {name} of {file} stands here twice")
            seen.add((file, name))
        if not cells:
            continue
        now = value_cell(code, file, names)
        if all((file, name) in code for name in names) and cells[1] != now:
            faults.append(f"{where}: {cells[0]} is {now} in {file}, not {cells[1]}; "
                          "docs/check.py --values")
        if len(cells) != 5 or not all(cells):
            faults.append(f"{where}: a row has constant, value, unit, what it decides, its source")
    for (file, name), value in sorted(code.items()):
        if (file, name) not in seen:
            faults.append(f"{file}: {name} = {value} is not in docs/thresholds.md; "
                          "docs/check.py --values")
    return faults


def bare_numbers(text):
    """Numbers of statements that compare, and those that options begin with. What is structure,
    rounding or "unlimited" is left out: whole numbers to 9, a half, 1.0 to 3.0, below 1e-6, above
    1e6, where a loop ends; and what only goes into sentences."""
    text = re.sub(r'"(\\.|[^"\\\n])*"', '""', without_comments(text))
    number = r"(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|\d+(?:e[-+]?\d+)?)(?![\w.])"
    beside = rf"(?<![<-])[<>]=?(?![<>])\s*-?{number}|{number}\s*(?:<=|>=|<(?!<)|(?<!-)>(?!>))"
    found = []
    for statement in re.split(r"[;{}]", text):
        if re.search(r"#include|constexpr|template|\bfor \(|<<|>>|^ *\w+ <=? [\d.]+$", statement):
            continue
        plain = re.sub(r"\b\w+<[\w:, *<>]*>(?=[\s({*&>:)])", " ", statement)  # templates' arguments
        near = [one or other for one, other in re.findall(beside, plain)]
        found += near
        if near or re.search(r"\w[\s)\]]*[<>]=?[\s(]*[\w-]", plain):
            found += [n for n in re.findall(number, plain) if "format(" not in plain and not n.isdigit()]
    for _, members in re.findall(r"struct (\w*Options)\b[^;{]*\{(.*?)\n\};", text, re.S):
        found += re.findall(rf"\b(?:double|float|int|std::size_t)\s[^;()]*?=\s*-?{number}", members)
    usual = {"0.0", "0.5", "1.0", "2.0", "3.0"}.union(str(n) for n in range(10))
    return sorted({n for n in found if n not in usual and 1e-6 < float(n) < 1e6}, key=float)


def check_bare_numbers(files):
    """Against the table of docs/thresholds.md that has a file and its numbers in each row."""
    faults, told = [], {}
    part = THRESHOLDS.read_text().partition(f"## {BARE}")[2].partition("\n## ")[0]
    for file, numbers in re.findall(r"^\| `([\w/.]+)` \| ([\d.e, +-]+) \|", part, re.M):
        told.setdefault(file, []).extend(n.strip() for n in numbers.split(","))
    for file in files:
        if not file.startswith(JUDGES) or not file.endswith((".h", ".cpp")):
            continue
        numbers = bare_numbers((ROOT / file).read_text())
        for n in numbers:
            if n not in told.get(file, []):
                faults.append(f"{file}: the number {n} decides something and is not in docs/thresholds.md, "
                              f"\"{BARE}\": give it a name, or a row")
        for n in told.pop(file, []):
            if n not in numbers:
                faults.append(f"docs/thresholds.md, \"{BARE}\": {file} has no {n} any more")
    return faults + [f"docs/thresholds.md, \"{BARE}\": there is no {file}" for file in told]


def comment_of(file, name):
    """What stands before a constant's line and behind it."""
    lines = (ROOT / file).read_text().split("\n")
    for number, line in enumerate(lines):
        if "constexpr" in line and re.search(rf"\b{name}\b", line):
            words = line.split("//", 1)[1:]
            while number > 0 and lines[number - 1].strip().startswith("//"):
                number -= 1
                words.insert(0, lines[number].strip()[2:])
            return " ".join(" ".join(words).split()).replace("|", "\\|")
    return ""


def bring_up_to_date(files):
    code, seen = code_constants(files), set()
    lines = THRESHOLDS.read_text().split("\n")
    for number, file, names, cells in table(lines):
        left = [name for name in names if (file, name) in code and (file, name) not in seen]
        seen |= {(file, name) for name in left}
        if not left:
            lines[number] = None
        elif cells:
            cells[0], cells[1] = ", ".join(left), value_cell(code, file, left)
            lines[number] = "| " + " | ".join(cells) + " |"
        elif left != names:
            cells = lines[number].strip("|").split("|")
            cells[1] = " " + ", ".join(left) + " "
            lines[number] = "|" + "|".join(cells) + "|"
    text = "\n".join(line for line in lines if line is not None)
    text = re.sub(r"### `[\w/.]+`\n\n\| constant[^\n]*\n\|[-|]+\n(?=\n|$)\n?", "", text)  # empty
    new, last = "", ""
    for (file, name), value in sorted(code.items()):
        if (file, name) in seen:
            continue
        if file != last:
            new += f"\n### `{file}`\n\n| constant | value | unit | decides | source |\n|---|---|---|---|---|\n"
        last = file
        new += f"| {name} | {value_cell(code, file, [name])} | ? | {comment_of(file, name) or '?'} | ? |\n"
    if new:
        heading = f"## {DRAWN}"
        text = text.replace(heading, f"## Not described yet\n{new}\n{heading}")
    THRESHOLDS.write_text(text)


def check_names(files):
    """Names that documents find in files, and files that are named."""
    faults = []
    tops = {name.split("/")[0] for name in files}
    whole = set(files) | {str(pathlib.PurePosixPath(f).parent) for f in files}
    whole |= {str(parent) for f in files for parent in pathlib.PurePosixPath(f).parents}
    for file in files:
        document = file.endswith(".md")
        comment = file.endswith((".h", ".cpp", ".inc", ".py", ".sh", ".txt", ".in")) or file == "dev"
        if not (document or comment) or "corpus" in file:
            continue
        try:
            text = (ROOT / file).read_text()
        except UnicodeDecodeError:
            continue
        if document:
            for match in re.finditer(r"`([\w:~]+)(?:\(\))?`\s+in\s+`([\w/]+\.\w+)`", text):
                name, target = match[1].split("::")[-1], match[2]
                path = ROOT / target
                line = text.count("\n", 0, match.start()) + 1
                if not path.is_file():
                    faults.append(f"{file}:{line}: there is no file {target}")
                elif not re.search(rf"\b{re.escape(name)}\b", path.read_text()):
                    faults.append(f"{file}:{line}: {target} has no {name}")
        # Documents without a folder: comments cite them by their path.
        for match in re.finditer(r"(?<![\w/.\-`*{}$])([A-Z][A-Z_]+\.md)\b", text):
            if comment and match[1] not in whole:
                line = text.count("\n", 0, match.start()) + 1
                faults.append(f"{file}:{line}: there is no {match[1]}")
        # Files of this tree; in code only documents, which are what comments cite.
        for match in re.finditer(r"(?<![\w/.\-])((?:[\w.\-]+/)+[\w\-]+\.(\w+))", text):
            target, ending = match[1], match[2]
            top = target.split("/")[0]
            if ending not in ("h", "cpp", "md", "sh", "py", "inc") or top not in tops | {"reference"}:
                continue
            if (comment and ending != "md") or re.search("NAME|ROOM", target):
                continue
            if target not in whole:
                line = text.count("\n", 0, match.start()) + 1
                faults.append(f"{file}:{line}: there is no {target}")
        faults += check_paths(file, text, tops, whole)
    return faults


def check_paths(file, text, tops, whole):
    """In documents `folder/name` without an ending, in comments of sources other sources."""
    stems = {re.sub(r"\.\w+$", "", name) for name in whole}
    ends = {end for name in whole for end in ends_of(name)}
    faults = []
    for number, line in enumerate(text.split("\n")):
        named = []
        if file.endswith(".md"):
            named = [name for name in re.findall(r"`((?:[\w\-]+/)+[\w\-]+)`", line)
                     if name.split("/")[0] in tops and not re.search("NAME|ROOM", name)]
        elif "//" in line and file.endswith((".h", ".cpp", ".inc")):
            comment = line.split("//", 1)[1]
            named = [name for name in re.findall(r"(?<![\w/.<*])((?:\w+/)*\w+\.(?:h|cpp|inc))\b", comment)
                     if not re.search(FOREIGN, name)]
        for name in named:
            if name not in stems and name not in ends:
                faults.append(f"{file}:{number + 1}: there is no {name}")
    return faults


CITED = re.compile(r"""(?:\[[\w/.]*\]\(([\w/.]+\.md)\)|`?\b((?:docs|bench)/[\w/]+\.md|CONTRIBUTING\.md)`?)
                       (?:,|:)?\s+(?://\s+|\#\s+)?"([^"\n]+)\"""", re.X)


def sections_of(text):
    """Headings, and the bold or slanted words that begin a paragraph."""
    found = re.findall(r"^#+ (.+)$|^(?:- )?\*+([^*\n]+?)[.:]?\*+", text, re.M)
    return [heading or words for heading, words in found]


def check_sections(files):
    """A document's section that is cited by its title: docs/theory.md, "The verdict"."""
    faults, sections = [], {}
    for file in files:
        if not file.endswith((".md", ".h", ".cpp", ".inc", ".py")) or file == "docs/check.py":
            continue
        text = (ROOT / file).read_text()
        for linked, plain, title in CITED.findall(text):
            beside = str((ROOT / file).parent.joinpath(linked).resolve().relative_to(ROOT)) if linked else ""
            target = plain or beside
            if target not in sections:
                path = ROOT / target
                sections[target] = sections_of(path.read_text()) if path.is_file() else []
            if not any(section.startswith(title.rstrip(",.")) for section in sections[target]):
                faults.append(f"{file}: {target} has no section \"{title}\"")
    return faults


def check_verdicts(files):
    """Whoever lowers a verdict stands in the table of docs/theory.md."""
    text = (ROOT / "docs/theory.md").read_text().partition("\n## The verdict\n")[2].partition("\n## ")[0]
    return [f"{file} lowers a verdict and is not in docs/theory.md, \"The verdict\""
            for file in files if file.endswith(".cpp") and not file.startswith(("tests/", "bench/"))
            and re.search(r"\blower\(\s*(?:\w+::max\()?(?:Verdict::|verdict|f\.verdict|check\.)",
                          (ROOT / file).read_text())
            and re.sub(r"\.cpp$", "", file) not in text]


def ends_of(name):
    parts = name.split("/")
    return ["/".join(parts[i:]) for i in range(len(parts))]


def rooms_of_table():
    """Room -> what it may include, in the table's order; None: all above."""
    may = {}
    for line in (ROOT / "docs/design.md").read_text().split("\n"):
        row = re.fullmatch(r"\| `([\w/]+)/` \|.*\| ([\w/, ]*) ?\|", line)
        if row:
            may[row[1]] = None if row[2].strip() == "all above" else re.findall(r"[\w/]+", row[2])
    return may


def room_of(file, rooms):
    folder = str(pathlib.PurePosixPath(file).parent)
    while folder != "." and folder not in rooms:
        folder = str(pathlib.PurePosixPath(folder).parent)
    return folder if folder in rooms else None


def is_named(room, names, own_folder):
    """A name stands for all that is within it, but in rows of rooms within it, where it is meant alone."""
    for name in names:
        alone = (own_folder + "/").startswith(name + "/")
        if room == name or (room.startswith(name + "/") and not alone):
            return True
    return False


def check_rooms(files):
    """Includes against the table of docs/design.md."""
    may = rooms_of_table()
    order = {room: number for number, room in enumerate(may)}
    faults = []
    for room, names in may.items():
        for name in names or []:
            if name not in may:
                faults.append(f"docs/design.md: the row of {room}/ names {name}/, which has no row")
            elif order[name] > order[room]:
                faults.append(f"docs/design.md: the row of {room}/ names {name}/, which stands below it")
    for file in files:
        room = room_of(file, may)
        if room is None or not file.endswith((".h", ".cpp", ".inc")):
            continue
        own_folder = room.rpartition("/")[0] or room
        for number, line in enumerate((ROOT / file).read_text().split("\n")):
            match = re.match(r'\s*#\s*include\s*["<](?:magimu/)?([\w/.]+)[">]', line)
            included = match and room_of(match[1], may)
            if not included or included == room:
                continue
            top = included.split("/")[0]  # these are for all, with all that is within them
            if top in ("graph", "statistics") and top != own_folder and top != room:
                continue
            allowed = (order[included] < order[room] if may[room] is None
                       else is_named(included, may[room], own_folder))
            if not allowed:
                faults.append(f"{file}:{number + 1}: {room}/ does not include {included}/ "
                              "(docs/design.md, \"The rooms\")")
    return faults


def check_tests(files):
    """A file of tests that no target has is never run, and nobody notices."""
    recipe = (ROOT / "tests/CMakeLists.txt").read_text()
    globs = re.search(r"foreach\(room ([^)]*)\)\s*#[^\n]*\n\s*file\(GLOB_RECURSE sources", recipe)
    rooms = globs.group(1).split() if globs else []
    own = {folder for folder in re.findall(r"SOURCE_DIR}/([\w/]+)/\*_test\.cpp", recipe)}
    return [f"{file} is in no target of tests/CMakeLists.txt" for file in files
            if re.fullmatch(r"tests/.*_test\.cpp", file) and file.split("/")[1] not in rooms
            and str(pathlib.PurePosixPath(file).parent)[len("tests/"):] not in own
            and pathlib.PurePosixPath(file).name not in recipe]


def folders_of(files):
    """Folder -> its own sources, without those of folders within it."""
    folders = {}
    for file in files:
        if file.endswith(SOURCES):
            folders.setdefault(str(pathlib.PurePosixPath(file).parent), []).append(file)
    return folders


def check_sizes(files):
    return [f"{folder}/ has {len(own)} sources, more than {MOST_FILES}: cut it into rooms"
            for folder, own in folders_of(files).items()
            if len(own) > MOST_FILES and not folder.startswith(UNCUT)]


def print_rooms(files):
    folders, sums = folders_of(files), [0, 0, 0]
    print("| room | files | lines | longest |\n|---|---|---|---|")
    for room in rooms_of_table():
        own = folders.get(room, [])
        lines = [len((ROOT / file).read_text().splitlines()) for file in own]
        print(f"| `{room}/` | {len(own)} | {sum(lines)} | {max(lines, default=0)} |")
        sums = [sums[0] + len(own), sums[1] + sum(lines), max([sums[2], *lines])]
    print(f"| in all | {sums[0]} | {sums[1]} | {sums[2]} |")


def main():
    write, rooms = sys.argv[1:] == ["--values"], sys.argv[1:] == ["--rooms"]
    if sys.argv[1:] and not (write or rooms):
        sys.exit(__doc__)
    files = tracked()
    if rooms:
        print_rooms(files)
        return
    if write:
        bring_up_to_date(files)
    faults = (check_thresholds(files) + check_bare_numbers(files) + check_names(files)
              + check_sections(files) + check_verdicts(files) + check_rooms(files) + check_sizes(files)
              + check_tests(files))
    for fault in faults:
        print(fault, file=sys.stderr)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
