# Sourced by tests of the program, with the program as first argument and the command that is tested,
# or nothing, in `tested`. Works in a folder of its own, and skips (exit 77) without an EGL device.
set -u
program=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
if ! "$program" render --list-devices | grep -q "4\.[5-9]"; then
  echo "no EGL device: skipped"
  exit 77
fi
failed=0
fail() {
  echo "FAILED: $*"
  failed=$((failed + 1))
}
# run CODE TEXT ARGUMENTS...: checks the exit code, and a part of what is printed into printed.txt.
run() {
  local expected=$1 text=$2 code
  shift 2
  "$program" $tested "$@" >"$work/printed.txt" 2>&1 </dev/null
  code=$?
  [ $code -eq "$expected" ] && [[ $(<"$work/printed.txt") == *"$text"* ]] ||
    fail "$tested $*: exit $code, expected $expected with \"$text\"; printed: $(tail -n 3 "$work/printed.txt")"
}
