#!/usr/bin/env python3
"""Writes the tables of options in docs/user-guide.md from what `psivox COMMAND --help-all` prints.

A table stands between `<!-- psivox render: Output -->` or `<!-- psivox render: --sampling --step -->`
and `<!-- end -->`. A group leaves out the options that another table of the command names. The table
of modes comes from include/psivox/modes.h.

  guide_tables.py PSIVOX GUIDE          says where they differ, and exits with 1
  guide_tables.py PSIVOX GUIDE --write  writes the guide
"""
import difflib
import pathlib
import re
import subprocess
import sys

TABLE = re.compile(r"(<!-- psivox (\w+): (.*?) -->\n).*?(<!-- end -->)", re.S)
MODES = re.compile(r"(<!-- modes -->\n).*?(<!-- end -->)", re.S)
ROW_OF_MODE = re.compile(r'X\((\w+),.*,\s*"([^"]+)"\)')
COMMANDS = ("render", "view", "info", "compare", "study", "verify", "examples")
COMMON = {"-h,--help", "--help-all"}


def options_of(psivox, command):
    """The command's options by group: {group: [(names, metavar, help, default)]}."""
    text = subprocess.run([psivox, command, "--help-all"], check=True, capture_output=True, text=True)
    groups, rows = {}, []
    for line in text.stdout.splitlines():
        if group := re.fullmatch(r"([A-Z]\w*):", line):
            rows = groups.setdefault(group[1], [])
        elif option := re.fullmatch(r"  (-\S+)( \S+)?(?: {2,}(.*))?", line):
            rows.append([option[1], (option[2] or "").strip(), option[3] or ""])
        elif rows and re.match(r" {10,}\S", line):
            rows[-1][2] += " " + line.strip()
    groups.pop("Examples", None)
    groups.pop("Arguments", None)
    return {group: [split_default(*row) for row in rows if row[0] not in COMMON]
            for group, rows in groups.items()}


def split_default(names, metavar, text):
    names = re.sub(r"\[=[^]]*\]", "", names)
    if found := re.fullmatch(r"(.*) \(default: (.*)\)", text.strip()):
        return names, metavar, found[1], found[2]
    return names, metavar, text.strip(), ""


def long_name(row):
    return row[0].split(",")[-1]


def markdown(text):
    text = re.sub(r"([|*<])", r"\\\1", text)
    return re.sub(r"(?<![\w`-])(--[a-z][a-z-]*|-o|\.[a-z]{2,4})(?!\w)", r"`\1`", text)


def table(rows):
    lines = ["| option | meaning | default |", "|---|---|---|"]
    for names, metavar, text, default in rows:
        value = (" " + metavar).rstrip().replace("|", "\\|")
        option = ", ".join(f"`{name}{value}`" for name in names.split(","))
        lines.append(f"| {option} | {markdown(text)} | {markdown(default)} |")
    return "\n" + "\n".join(lines) + "\n\n"


def named(choice):
    return choice.split() if choice.startswith("--") else []


def table_of_modes():
    header = pathlib.Path(__file__).parent.parent / "include/psivox/modes.h"
    rows = ROW_OF_MODE.findall(header.read_text(encoding="utf-8"))
    lines = [f"| `{name.replace('_', '-')}` | {text} |" for name, text in rows]
    return "\n" + "\n".join(["| `--mode` | the picture |", "|---|---|", *lines]) + "\n\n"


def rewritten(guide, commands):
    tables = [(found[2], found[3]) for found in TABLE.finditer(guide)]
    named_elsewhere = {(command, name) for command, choice in tables for name in named(choice)}

    def rows_of(command, choice):
        groups = commands[command]
        everything = {long_name(row): row for rows in groups.values() for row in rows}
        if named(choice):
            return [everything[name] for name in named(choice)]
        return [row for row in groups[choice] if (command, long_name(row)) not in named_elsewhere]

    guide = MODES.sub(lambda m: m[1] + table_of_modes() + m[2], guide)
    return TABLE.sub(lambda m: m[1] + table(rows_of(m[2], m[3])) + m[4], guide)


def main():
    psivox, path = sys.argv[1:3]
    with open(path, encoding="utf-8") as file:
        guide = file.read()
    commands = {command: options_of(psivox, command) for command in COMMANDS}
    wanted = rewritten(guide, commands)
    if "--write" in sys.argv:
        with open(path, "w", encoding="utf-8") as file:
            file.write(wanted)
    options = {name for groups in commands.values() for rows in groups.values() for row in rows
               for name in row[0].split(",") if name.startswith("--")}
    in_guide = set(re.findall(r"--[a-z][a-z-]+", wanted)) - {"--help", "--help-all", "--version"}
    sys.stdout.writelines(f"not an option: {name}\n" for name in sorted(in_guide - options))
    sys.stdout.writelines(f"not in the guide: {name}\n" for name in sorted(options - in_guide))
    changed = "--write" not in sys.argv and list(difflib.unified_diff(
        guide.splitlines(), wanted.splitlines(), "guide", "--help-all", lineterm="", n=0))
    if changed:
        print(*changed, "tools/guide_tables.py PSIVOX docs/user-guide.md --write", sep="\n")
    sys.exit(1 if changed or in_guide ^ options else 0)


main()
