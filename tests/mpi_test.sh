#!/usr/bin/env bash
# mpi_test.sh PSIVOX ASSETS: several processes draw one picture, by each MPI that there is a module
# and an mpirun for. It must be that of one process. Jobs that fail must end with one line of psivox,
# its exit code and no picture. Without MPI or an EGL device it is skipped (exit 77).
set -u
program=$(realpath "$1") assets=$(realpath "$2")
libraries=$(dirname "$(ldd "$program" | sed -n 's/.*libpsivox\.so[^ ]* => \([^ ]*\) .*/\1/p')")
mpis=()
for mpi in openmpi mpich; do
  [ -e "$libraries/psivox/libpsivox_$mpi.so" ] && command -v "mpirun.$mpi" >/dev/null && mpis+=("$mpi")
done
if ((${#mpis[@]} == 0)); then
  echo "skipped: no MPI (Debian: libopenmpi-dev openmpi-bin, libmpich-dev mpich)"
  exit 77
fi
if ! "$program" render --list-devices | grep -q "4\.[5-9]"; then
  echo "skipped: no EGL device"
  exit 77
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
# as root, in a container, with more processes than cores
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_hwloc_base_binding_policy=none

failures=0
fail() {
  echo "FAILED: $1"
  [ -e output ] && tail -n 5 output
  failures=$((failures + 1))
}
V=$assets/blobs.vdb
scene=(--look plain --sampling cells --early-termination 0 --resolution 64x48 --pixel-samples 2)
# Whether Open MPI's mpirun itself has crashed, and nothing else: its own process has printed a stack
# trace that goes through its messages, and no other process has, nor has mpirun seen one crash.
launcher_crashed() {
  local own
  own="^\\[[^]]*:0*$(<launcher)\\]"
  grep -q "$own \*\*\* Process received signal" output &&
    grep "$own" output | grep -qE 'mca_oob_tcp|pmix' &&
    ! grep -F '*** Process received signal' output | grep -qv "$own" &&
    ! grep -q 'noticed that process rank' output
}
# launch MPI COUNT COMMAND...: that job, once more if its launcher crashes.
launch() {
  local mpi=$1 count=$2 tries got
  shift 2
  for tries in 1 2; do
    # shellcheck disable=SC2016
    timeout 60 bash -c 'echo $$ >launcher && exec "$@"' bash "mpirun.$mpi" -n "$count" "$@" >output 2>&1
    got=$?
    launcher_crashed || break
    echo "mpirun.$mpi itself crashed, try $tries of 2: $*"
  done
  return $got
}
# on MPI COUNT ARGUMENTS...: psivox render in so many processes.
on() {
  local mpi=$1 count=$2
  shift 2
  launch "$mpi" "$count" "$program" render "$@"
}

# --- the same picture -----------------------------------------------------------------------------
"$program" render "$V" -o one.exr "${scene[@]}" --aov transmittance -q || fail "one process"
for mpi in "${mpis[@]}"; do
  on "$mpi" 1 "$V" -o alone.exr "${scene[@]}" --aov transmittance || fail "$mpi: one rank ends with $?"
  cmp -s one.exr alone.exr || fail "$mpi: one rank draws another picture than one process"
  on "$mpi" 4 "$V" -o "$mpi.exr" "${scene[@]}" --aov transmittance || fail "$mpi: four ranks end with $?"
  # each rank's part and the fold are rounded to float32, 1e-7 of values about 1
  "$program" compare one.exr "$mpi.exr" --max-rms 1e-6 >/dev/null ||
    fail "$mpi: four ranks draw another picture than one process"
  cmp -s "${mpis[0]}.exr" "$mpi.exr" || fail "$mpi: another picture than by ${mpis[0]}"
  lines=$(grep -c '^psivox:' output)
  [ "$lines" -le 1 ] || fail "$mpi: $lines lines of psivox"  # what auto has chosen, if anything
done
# What is drawn does not depend on the MPI that carries it: the last one carries these.
mpi=${mpis[-1]}
for how in "--mode mip" "--mode lmip --lmip-threshold 0.2" "--mode isosurface" "--mode xray" \
  "--sampling uniform" "--extinction 4 --light 0.3,-1,-0.5" "--lod 1" \
  "--value-scale log --colormap viridis --range 20%,95%"; do
  # shellcheck disable=SC2086
  "$program" render "$V" -o 1.exr "${scene[@]}" $how -q || fail "$how: one process"
  # shellcheck disable=SC2086
  on "$mpi" 4 "$V" -o ranks.exr "${scene[@]}" $how || fail "$mpi, $how: the ranks end with $?"
  "$program" compare 1.exr ranks.exr --max-rms 1e-6 >/dev/null ||
    fail "$mpi, $how: the ranks draw another picture than one process"
done

# --- the same look ----------------------------------------------------------------------------------
# Every parameter has the same bits: what auto chooses, from percentages, sums along lines and the
# camera. A fire, a scan, a smoke, and a scan of many parts, cut off.
for how in "$V" "$assets/ramp.vdb" "$assets/slab.vdb" \
  "$V --grid density --look scan --clip-plane -z=0.2"; do
  read -ra picture <<<"$how -q --print-scene --resolution 16x12"
  "$program" render "${picture[@]}" -o 1.exr >one.json || fail "$how: one process"
  on "$mpi" 4 "${picture[@]}" -o ranks.exr || fail "$mpi, $how: the ranks end with $?"
  diff one.json output >differences || fail "$mpi, $how: another look: $(<differences)"
  # the light of both keeps the tolerance of 1e-3
  "$program" compare 1.exr ranks.exr --max-rms 2e-3 >/dev/null ||
    fail "$mpi, $how: the ranks draw another picture than one process"
done

# --- failures: one line, its exit code, no picture ---------------------------------------------------
mpi=${mpis[0]}
# by_rank ARGUMENTS...: psivox render, in folder b for rank 1 and in a for the others. Where the folder
# has a file `dies`, it is killed; with `dies_later`, when some of the work is done.
cat >by_rank <<END
#!/usr/bin/env bash
rank=\${OMPI_COMM_WORLD_RANK:-\${PMI_RANK:-0}}
if [ "\$rank" = 1 ]; then cd b; else cd a; fi
[ -e dies ] && exec timeout --signal=KILL 2 "$program" render "\$@"
[ -e dies_later ] && (
  until grep -q "^psivox: lighting [1-9].* %" ../output; do sleep 0.1; done
  date +%s >../died
  kill -KILL \$\$
) &
exec "$program" render "\$@"
END
chmod +x by_rank
mkdir a b
# A job of that kind that ends well takes so long here; one that fails may take ten seconds more.
begin=$SECONDS
launch "$mpi" 2 ./by_rank "${scene[@]}" --renderer march-double "$V" -o ../well.exr ||
  fail "two ranks in two folders end with $?"
most=$((SECONDS - begin + 10))
# ends CODE TEXT ARGUMENTS...: that job of two ranks ends like this, in time.
ends() {
  local code=$1 text=$2 begin=$SECONDS got
  shift 2
  launch "$mpi" 2 ./by_rank "${scene[@]}" --renderer march-double "$@" -o ../fails.exr
  got=$?
  [ "$got" -eq "$code" ] || fail "exit code $got instead of $code: $*"
  ((SECONDS - begin <= most)) || fail "it took $((SECONDS - begin)) s to fail: $*"
  if [ -n "$text" ]; then
    grep -q "^psivox.*$text" output || fail "no word of '$text': $*"
    [ "$(grep -c '^psivox' output)" -eq 1 ] || fail "more than one line of psivox: $*"
  fi
  stray=$(find . -name '*fails*')
  [ -z "$stray" ] || fail "a half picture: $stray"
}
ends 2 "unknown option" "$V" --resolutoin 4x4
ends 2 "without --explain" "$V" --explain
ends 2 "not a sequence" "$V" --turntable 3
ends 2 "in --mode alpha" "$V" --mode slice
cp "$V" a/x.vdb
ends 3 "rank 1 of 2, on .*x.vdb" x.vdb
cp "$assets/ramp.vdb" b/x.vdb
ends 3 "rank 1 sees another volume" x.vdb
cp "$V" b/x.vdb
echo '{"extinction": 2}' >a/scene.json && echo '{"extinction": 3}' >b/scene.json
ends 3 "rank 1 has other options" x.vdb --scene scene.json
touch b/dies  # as by the system, out of memory
ends 137 "" x.vdb --resolution 2000x2000 --pixel-samples 100
rm b/dies && touch b/dies_later  # in the middle of light: exact light of a sky would take minutes
for mpi in "${mpis[@]}"; do
  rm -f died
  launch "$mpi" 2 ./by_rank "${scene[@]}" --renderer march-double x.vdb --extinction 3 --sky 1,1,1 \
    --light-quality exact -o ../fails.exr && fail "$mpi: exit code 0 after a rank was killed"
  if [ -e died ]; then
    (($(date +%s) - $(<died) <= most)) || fail "$mpi: it took $(($(date +%s) - $(<died))) s to end"
  else
    fail "$mpi: no rank was killed while there was light to compute"
  fi
  stray=$(find . -name '*fails*')
  [ -z "$stray" ] || fail "$mpi: a half picture: $stray"
done
((failures == 0)) && echo "one picture by 4 processes, under ${mpis[*]}: that of one process"
exit $((failures > 0))
