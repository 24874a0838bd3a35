#!/usr/bin/env bash
# run.sh MINUTES [TARGET...]: fuzzes each target, or those named, for so long, from the corpus.
# What is found stays in build/fuzz/found/TARGET: a file that crashes, put into corpus/TARGET, is
# replayed by the test fuzz_corpus from then on. Exit code 1 if anything was found.
set -euo pipefail
cd "$(dirname "$0")/../.."

minutes=${1:?usage: tests/fuzz/run.sh MINUTES [TARGET...]}
shift
targets=("$@")
((${#targets[@]})) ||
  targets=(scene function gltf glb pvcc path frames parameter command picture scan)

export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1
# OpenVDB leaks the nodes of trees that are cut off: leaks are not looked for, and each process
# (-fork) ends when it has taken too much memory.
export ASAN_OPTIONS=detect_leaks=0
# the first clang of 16 or later; an earlier build folder keeps its own
for clang in "${CXX-}" clang++-{16,17,18,19,20,21,22} clang++; do
  [[ $clang ]] && command -v "$clang" >/dev/null && break
done
CXX=$clang cmake --preset fuzz >/dev/null
cmake --build --preset fuzz
status=0
for target in "${targets[@]}"; do
  work=build/fuzz/found/$target
  mkdir -p "$work/corpus"
  printf '== %s\n' "$target"
  PSIVOX_FUZZ_TARGET=$target build/fuzz/tests/fuzz/psivox_fuzz -fork=1 -ignore_ooms=1 \
    -max_total_time=$((minutes * 60)) -timeout=10 -rss_limit_mb=4096 -max_len=65536 \
    -artifact_prefix="$work/" -print_final_stats=1 -close_fd_mask=1 \
    "$work/corpus" "tests/fuzz/corpus/$target" >"$work/log" 2>&1 || status=1
  grep -E 'ERROR|SUMMARY|Test unit written' "$work/log" || grep '^#' "$work/log" | tail -n 1
done
exit $status
