# Sourced as cli_setup.sh is, by tests that drive headless Chromium. Skips (exit 77) without Chromium,
# its driver or Python, too.
for needed in chromium chromedriver python3; do
  if ! command -v $needed >/dev/null; then
    echo "no $needed: skipped"
    exit 77
  fi
done
. "$(dirname "$0")/cli_setup.sh"
