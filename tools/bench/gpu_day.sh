#!/usr/bin/env bash
# gpu_day.sh [--short] [--psivox PROGRAM] [--data FOLDER] [--out FOLDER]
# What a machine with a GPU tells about psivox, in one run of at most 8 minutes, without a network:
#   verify    psivox verify, by the driver's own shaders
#   tests     the tests that draw by OpenGL, where they are built
#   race      compare_gpu.py: GPU time at RMS 1e-2 to 1e-5, psivox and the CUDA loop
#   default   times of the stages of four default pictures, whole processes, the second of two
#   window    psivox view --benchmark-orbit at 1920x1080, tolerance 1e-2
# Prints one table and writes OUT/gpu-day.csv (part, case, quantity, value, unit). Needs a built
# psivox; for the race build/peers of compare_peers.py (volumes of A and B, .nvdb files), and nvcc or a
# built loop; for the window a display or xvfb-run. What is missing is said and left out.
# --short: small pictures and one scene, to try the script where there is no GPU.
set -uo pipefail
cd "$(dirname "$0")/../.."
psivox=build/release/bin/psivox data=../shared/data out=build/gpu-day
size=1024 scenes=smoke,A,B,cloud,heptane repeats=7 pictures=120 window=1920x1080 resolution=1280x720
while (($#)); do
  case $1 in
    --short) size=96 scenes=smoke repeats=1 pictures=12 window=320x200 resolution=320x180 ;;
    --psivox) psivox=$2 && shift ;;
    --data) data=$2 && shift ;;
    --out) out=$2 && shift ;;
    *) sed -n '2,14p' "$0" | cut -c3- && exit 2 ;;
  esac
  shift
done
[[ -x $psivox ]] || { echo "no $psivox: build it, or give --psivox" >&2 && exit 2; }
mkdir -p "$out"
csv=$out/gpu-day.csv
echo "part,case,quantity,value,unit" >"$csv"
row() { printf '%s,%s,%s,%s,%s\n' "$@" >>"$csv"; }
# part SECONDS NAME COMMAND...: its output is in OUT/NAME.log
part() {
  local limit=$1 name=$2 start=$SECONDS
  shift 2
  echo "$name: $*" >&2
  timeout "$limit" "$@" >"$out/$name.log" 2>&1
  local code=$?
  row "$name" - "exit code" $code -
  row "$name" - time $((SECONDS - start)) s
  ((code == 0)) || { echo "$name ends with $code:" >&2 && tail -n 5 "$out/$name.log" >&2; }
}

nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2>/dev/null | tee "$out/card.txt" >&2
part 60 verify "$psivox" verify --json
row verify - renderer \
  "$(sed -n 's/^ *"renderer": "\(.*\)",*$/\1/p' "$out/verify.log" | head -n 1 | tr ',' ' ')" -

tests=$(dirname "$psivox")/../CTestTestfile.cmake
if [[ -f $tests && $scenes != smoke ]]; then
  part 120 tests ctest --test-dir "$(dirname "$tests")" -R '^(march|regions|gradient|codes|environment)_test$'
else
  echo "tests: left out" >&2
fi

if [[ -f build/peers/scene.vdb || $scenes == smoke ]]; then
  part 200 race python3 tools/bench/compare_gpu.py --scenes "$scenes" --size "$size" --repeats "$repeats" \
    --psivox "$psivox" --data "$data"
else
  echo "race: left out: build/peers of tools/bench/compare_peers.py is needed" >&2
fi

for file in smoke cloud_tiles heptane frogtissue; do
  [[ -f $data/$file.vdb ]] || continue
  for turn in 1 2; do  # the first fills the driver's cache of programs
    "$psivox" render "$data/$file.vdb" -q --resolution $resolution -o "$out/$file.png" \
      --stats "$out/$file.json" || row default $file "exit code" $? -
  done
done

run_view=()
if [[ -z ${DISPLAY-} ]]; then run_view=(xvfb-run -a -s "-screen 0 ${window}x24"); fi
if [[ -n ${DISPLAY-} ]] || command -v xvfb-run >/dev/null; then
  part 60 window "${run_view[@]}" "$psivox" view "$data/smoke.vdb" --tolerance 1e-2 \
    --resolution $window --benchmark-orbit $pictures
else
  echo "window: left out: no display and no xvfb-run" >&2
fi

python3 - "$out" "$csv" build/peers/gpu.json <<'PYTHON'
import csv, json, pathlib, re, sys

out, table, race = map(pathlib.Path, sys.argv[1:])
rows = list(csv.reader(table.open()))
if (out / "race.log").exists() and race.exists():
    for r in json.loads(race.read_text()):
        rows.append(["race", f"{r['scene']} {r['method']} {r['step']}", f"GPU time at RMS {r['rms']:.2e}",
                     f"{r['march_gpu_ms']:.3f}", "ms"])
for stats in sorted(out.glob("*.json")):
    found = json.loads(stats.read_text())
    for stage, ms in found["times_ms"].items():
        rows.append(["default", stats.stem, stage, f"{ms:.1f}", "ms"])
    rows.append(["default", stats.stem, "look-ups a ray", f"{found['counts']['samples_per_ray']:.1f}", "-"])
window = out / "window.log"
if window.exists():
    for share, ms in re.findall(r"(\d+) % within ([\d.]+) ms", window.read_text()):
        rows.append(["window", "smoke", f"interval of {share} %", ms, "ms"])
csv.writer(table.open("w", newline="")).writerows(rows)
for row in rows[1:]:
    print(f"{row[0]:<9}{row[1]:<42} {row[2]:<28} {row[3]:>9} {row[4]}")
PYTHON
if [[ -f $out/race.log ]]; then cat "$out/race.log"; fi
