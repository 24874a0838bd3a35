#!/usr/bin/env bash
# Prints the README's N-th set-up command, to the end of its block: tools/set-up-command.sh N
awk -v wanted="$1" '/^tools\/install-deps\.sh / && ++found == wanted { inside = 1 }
                    /^```/ { inside = 0 }
                    inside' "$(dirname "$0")/../README.md"
