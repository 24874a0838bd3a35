#!/usr/bin/env bash
# Tests psivox study as its users call it: study_cli_test.sh PSIVOX ASSETS. Without an EGL device it
# skips (exit 77).
tested=study assets=$2
. "$(dirname "$0")/cli_setup.sh"

# A study's CSV without its times, the last 15 columns.
numbers() { sed -E 's/(,[^,]*){15}$//' "$1/results.csv"; }
rows() { tail -n +2 "$1/results.csv" 2>/dev/null | wc -l; }
# stop_by SIGNAL FOLDER: starts a study, which gets the signal when it has two rows. Sets code.
stop_by() {
  "$program" study "${sweep[@]}" -o "$2" 2>"$2.txt" &
  local pid=$!
  for _ in $(seq 600); do
    [ "$(rows "$2")" -ge 2 ] && break
    sleep 0.05
  done
  kill -"$1" $pid
  wait $pid
  code=$?
}

sweep=("$assets/blobs.vdb" --resolution 32x24 --luminance-grid density -q --repeats 2
  --integrators porter-duff,psi-exact,cell-exact --segments 1 --steps 1,0.5)

# --- a whole study -----------------------------------------------------------------------------
run 0 "" "${sweep[@]}" -o whole
[ "$(rows whole)" = 7 ] || fail "whole: $(rows whole) rows, expected 7"
for file in results.csv results.json index.html reference.exr reference.png turning.html \
  pictures/psi-exact_step_0.5.png differences/cell-exact_cells.png; do
  [ -s "whole/$file" ] || fail "no $file"
done
[ "$(grep -c '"reason": "--integrator cell-exact' whole/results.json)" = 2 ] || fail "no reason for what is left out"
# 1 + 2 * 7 pictures; no external resources. page_test.py reads what a browser shows.
[ "$(grep -oE '"(reference|(pictures|differences)/[^"]*)\.png":"iVBOR' whole/index.html | wc -l)" = 15 ] ||
  fail "index.html lacks pictures"
sentence=$(sed -n 's/^ *"sentence": "\(.*\)",$/\1/p' whole/results.json)
grep -q '^For 8 bits use .* look-ups a ray' <<<"$sentence" || fail "results.json concludes: $sentence"
grep -qF "$sentence" whole/index.html || fail "index.html has no '$sentence'"
sentence=${sentence//\`/}
grep -oE ' (src|href)=|url\(' whole/index.html && fail "index.html asks for files"

# --- resuming ----------------------------------------------------------------------------------
run 2 "--resume" "${sweep[@]}" -o whole
run 2 "another --extinction" "${sweep[@]}" -o whole --resume --extinction 1
# A reference that lies about its size is drawn again, and a scene that is none is no end of psivox.
mkdir lying nowhere && sed 's/"resolution": \[32,24\]/"resolution": [64,48]/' whole/reference.exr >lying/reference.exr
run 0 "" "${sweep[@]}" -o lying --resume --resolution 64x48 --integrators psi-exact --no-split
sed 's/^ "scene": {$/ "scene": 5, "other": {/' whole/results.json >nowhere/results.json
run 3 "not the results of a study" "${sweep[@]}" -o nowhere --resume
run 2 "porter-duff step 0.5" "${sweep[@]}" -o whole --resume --steps 1
exec 9<whole
flock 9
run 5 "another process writes" "${sweep[@]}" -o whole --resume
exec 9<&-
before=$(md5sum whole/results.csv)
loud=("${sweep[@]/#-q/--resume}")
"$program" study "${loud[@]}" -o whole 2>/dev/null | tr -d '\`' | grep -qxF "$sentence" ||
  fail "the terminal does not say '$sentence'"
[ "$before" = "$(md5sum whole/results.csv)" ] || fail "resuming a finished study changed it"

# Killed at an arbitrary moment, then resumed: equal results except for the times.
for points in 0 7; do
  "$program" study "${sweep[@]}" -o "killed$points" &
  pid=$!
  for _ in $(seq 600); do
    [ -s "killed$points/results.csv" ] && [ "$(rows "killed$points")" -ge $points ] && break
    sleep 0.05
  done
  kill -9 $pid
  wait $pid 2>/dev/null
  run 0 "" "${sweep[@]}" -o "killed$points" --resume
  diff <(numbers whole) <(numbers "killed$points") >/dev/null ||
    fail "killed after $points points and resumed: another CSV"
done

# Lists of a value that is none, and of nothing.
run 2 "--steps: 'auto' is no value to study" "${sweep[@]}" -o none --steps auto
run 2 "--steps is empty" "${sweep[@]}" -o none --steps ""
run 2 "give -o DIR" "${sweep[@]}" -o -
run 0 "the picture is empty: --extinction is 0" "$assets/blobs.vdb" -o empty --resolution 8x8 \
  --look plain --extinction 0 --integrators midpoint --samplings uniform --steps 1 --repeats 1

# Ctrl-C leaves whole files, a report of the finished points, and exit code 130. (A shell's
# background jobs ignore SIGINT unless job control is on.)
set -m
stop_by INT stopped
set +m
[ $code -eq 130 ] || fail "interrupted: exit $code"
grep -q -- "--resume" stopped.txt || fail "interrupted: no word of --resume"
[ -s stopped/index.html ] || fail "interrupted: no report"
if compgen -G 'stopped/.*' | grep -vE '/\.{1,2}$'; then fail "interrupted: half-written files"; fi
run 0 "" "${sweep[@]}" -o stopped --resume
diff <(numbers whole) <(numbers stopped) >/dev/null || fail "interrupted and resumed: another CSV"

# SIGTERM ends it at once, with whole files.
stop_by TERM ended
[ $code -eq 143 ] || fail "SIGTERM: exit $code"
if compgen -G 'ended/.psivox*'; then fail "SIGTERM: half-written files"; fi
run 0 "" "${sweep[@]}" -o ended --resume

# --- names of others are text on a page, and no page runs what it should not ------------------------
evil='<img src=x onerror=alert(1)>"'
cp -r whole foreign
cp whole/pictures/psi-exact_step_0.5.png other.png
run 0 "" "${sweep[@]}" -o foreign --resume --add other=other.png
sed -i "s/\"other\"/\"${evil/\"/}\"/" foreign/results.json
run 0 "" "${sweep[@]}" -o foreign --resume
for page in foreign whole; do
  ! grep -qF '<img src=x' $page/index.html || fail "$page: a name is markup"
  grep -q 'http-equiv="Content-Security-Policy" content="default-src .none.;' $page/index.html ||
    fail "$page: no policy"
done
grep -qF '\u003cimg src=x' foreign/index.html || fail "a name is not there"
grep -q 'Content-Security-Policy' whole/turning.html || fail "turning.html: no policy"

# --- a study file, and refused options -----------------------------------------------------------
cat >study.json <<EOF
{"integrators": ["midpoint"], "samplings": "uniform", "steps": [1], "repeats": 1,
 "scene": {"resolution": [16, 16]}}
EOF
run 0 "" "$assets/blobs.vdb" --study study.json -o file -q --no-split --texels all --filters all
[ "$(rows file)" = 5 ] || fail "study file: $(rows file) rows, expected 5"
echo '{"stpes": [1]}' >bad.json
run 2 "did you mean steps?" "$assets/blobs.vdb" --study bad.json -o bad
echo '{"points": [{"value": 0, "attenuation": 1}], "isosurfaces": [{"value": 0.5, "thickness": 1, "attenuation": 1}]}' >shells.json
run 0 "" "$assets/blobs.vdb" --transfer-function shells.json --luminance 1,1,1 --resolution 16x16 -q \
  --repeats 1 --no-split --integrators midpoint,cell-exact --segments 2 --steps 1 -o shells
[ "$(rows shells)" = 2 ] || fail "a function of the gradient: $(rows shells) rows, expected 2"
run 2 "did you mean --integrators?" "$assets/blobs.vdb" --integrator midpoint -o bad
run 2 "did you mean psi-exact?" "$assets/blobs.vdb" --integrators psi-exatc -o bad
# templates cannot follow the look's fire, which is another grid
run 0 "" "$assets/blobs.vdb" --projection orthographic --samplings cells,template -q --repeats 1 \
  --no-split --integrators midpoint --segments 1 --resolution 16x16 -o template
[ "$(rows template)" = 1 ] || fail "template: $(rows template) rows, expected 1"
grep -q '"reason": ".*none may emit' template/results.json || fail "no reason for the template"
run 2 "--output is required" "$assets/blobs.vdb"
run 2 "IN.vdb" -o bad
run 2 "from 1 to 1000" "$assets/blobs.vdb" -o bad --repeats 0
run 3 "no such file" nope.vdb -o bad
run 5 "cannot make" "$assets/blobs.vdb" -o study.json/sub

# --- the scene is what render draws -------------------------------------------------------------
brief=(--integrators midpoint --segments 1 --resolution 32x24 --repeats 1 --no-split -q)
scene_of() { sed -n '/^ "scene": {/,/^ }/p' "$1/results.json" | grep -v '"input"'; }
# field of the JSON, a text
json_text() { sed -n "s/^ *\"$2\": \"\(.*\)\",\{0,1\}$/\1/p" "$1/results.json" | head -n 1; }
# No asset is a level set, so the surface is asked for. Look-ups tell the methods apart; times, which
# vary, do not.
for look in fire:blobs scan:ramp smoke:rotated "surface:blobs --look surface"; do
  name=${look%%:*} file=${look#*:}
  read -ra options <<<"$file"
  options[0]=$assets/${options[0]}.vdb
  methods=(--samplings uniform --steps 4,1)
  [ $name = surface ] && methods=(--samplings cells)
  run 0 "" "${options[@]}" "${brief[@]}" "${methods[@]}" -o "look-$name"
  "$program" render "${options[@]}" --resolution 32x24 -q -o "$name.png" --print-scene >"$name.json"
  run 0 "" --scene "$name.json" "${brief[@]}" "${methods[@]}" -o "scene-$name"
  [ "$(json_text "look-$name" sentence)" = "$(json_text "scene-$name" sentence)" ] ||
    fail "$name: studies of a file and of its printed scene conclude differently"
  diff <(scene_of "look-$name") <(scene_of "scene-$name") || fail "$name: another scene"
  diff <(numbers "look-$name") <(numbers "scene-$name") || fail "$name: another CSV"
  # Render's picture and that of the page's command are the reference's, but for the tolerance and
  # half a code of 8 bits, which near white is 2.3 / 510 of linear light.
  command=$(json_text "look-$name" command)
  eval "\"$program\" ${command#psivox } -q" || fail "$name: '$command'"
  for picture in "$name.png" picture.png; do
    "$program" compare $picture "look-$name/reference.png" --max-rms 5e-3 >compared.txt ||
      fail "$name: $picture is another picture: $(cat compared.txt)"
  done
done
grep -q '"emission-grid": "temperature"' look-fire/results.json || fail "fire: no emission"
grep -A 3 '"light": ' look-fire/results.json | grep -q camera || fail "fire: no light"
run 2 "no such look" "$assets/blobs.vdb" --look nonsense -o bad
run 2 "does not march" "$assets/blobs.vdb" --mode slice -o bad
# The errors are the rules', since the light is the reference's too: in exact cells only rounding is
# left, of which 1e-6 is a few times what is seen.
run 0 "" "$assets/blobs.vdb" "${brief[@]}" --integrators cell-exact --samplings cells -o exact
# Columns of a study's CSV by their names, without the header.
columns() {
  awk -F, -v names="$2" 'NR == 1 { n = split(names, name, ","); for (i = 1; i <= NF; ++i) at[$i] = i }
    NR > 1 { for (i = 1; i <= n; ++i) printf "%s%s", $at[name[i]], i < n ? "," : "\n" }' "$1/results.csv"
}
awk -v rms="$(columns exact rms)" 'BEGIN { exit !(0 < rms && rms < 1e-6) }' ||
  fail "exact cells are off by $(columns exact rms)"

# Constant luminance in cells: rules that know a cell's optical depth cannot differ.
alike=("$assets/blobs.vdb" --look plain --resolution 32x24 --repeats 1 --no-split --samplings cells
  --segments 1 --integrators porter-duff,average,psi-exact)
run 0 'use `--segments 1` with average or psi-exact: ' "${alike[@]}" -o alike
run 0 "psivox render $assets/blobs.vdb --output=picture.png" "${alike[@]}" -o alike --resume

# --- a rule that is broken on the GPU ------------------------------------------------------------
# Its weights are swapped. The march in double is compiled in and keeps the correct ones.
cp -r "$assets/../shaders" broken_shaders
rule=broken_shaders/integrators/psi_exact.glsl
sed -i 's/return Weights(\(.*\), real(0.0), \(.*\), s.depth)/return Weights(\2, real(0.0), \1, s.depth)/' $rule
cmp -s $rule "$assets/../shaders/integrators/psi_exact.glsl" && fail "psi_exact.glsl is not broken"
PSIVOX_SHADER_DIR=$PWD/broken_shaders run 0 "" "${sweep[@]}" --integrators psi-exact --samplings cells -o broken
errors() { columns "$1" step_error_radiance_rms,arithmetic_error_radiance_rms; }
run 0 "" "${sweep[@]}" --integrators psi-exact --samplings cells -o sound
awk -F, -v broken="$(errors broken)" -v sound="$(errors sound)" 'BEGIN {
  split(broken, b); split(sound, s)
  exit !(b[1] == s[1] && s[2] > 0 && s[2] < 1e-6 && b[2] > 1000 * s[2]) }' ||
  fail "a broken rule's errors are $(errors broken), a sound one's $(errors sound)"

# --- tolerances ---------------------------------------------------------------------------------
run 0 "" "${sweep[@]}" -o asked --integrators midpoint --segments 1 --steps 1 --tolerances 1e-2,1e-4
[ "$(rows asked)" = 4 ] || fail "asked: $(rows asked) rows, expected 4"
# the chosen methods; the error must not exceed the tolerance
columns asked integrator,tolerance,rms | awk -F, '$2 > 0 { n += $1 != "" && $3 <= $2 } END { exit n != 2 }' ||
  fail "tolerances were not kept: $(columns asked integrator,tolerance,rms)"
grep -q '"curve": "chosen by tolerance"' asked/results.json || fail "no curve of tolerances"
before=$(md5sum asked/results.csv)
run 0 "" "${sweep[@]}" -o asked --integrators midpoint --segments 1 --steps 1 --tolerances 1e-2,1e-4 --resume
[ "$before" = "$(md5sum asked/results.csv)" ] || fail "resuming a study of tolerances changed it"

# --- a page that stands, resolutions ---------------------------------------------------------------
# a study does not replace a page that is not its own
mkdir web && echo mine >web/index.html
run 2 "'web' holds an index.html; give another folder with -o" "${sweep[@]}" -o web
run 2 "'web' holds an index.html" --suite -o web
[ "$(cat web/index.html)" = mine ] || fail "web/index.html was replaced"

run 0 "" "${sweep[@]}" -o sizes --resolutions 24x24,48x16 --integrators psi-exact --segments 1,2
for file in reference_24x24.exr reference_48x16.png pictures/psi-exact_cells_2_24x24.png; do
  [ -s "sizes/$file" ] || fail "no sizes/$file"
done
[ "$(columns sizes resolution | sort | uniq -c | tr -s ' \n' ' ')" = " 4 24x24 4 48x16 " ] ||
  fail "sizes: $(columns sizes resolution | sort | uniq -c)"
# an error like that of step 1 shows that each picture was compared with a reference of its own size
columns sizes rms | awk '!($1 < 1e-2) { exit 1 }' || fail "sizes: errors of another size's reference"

# --- other renderers ------------------------------------------------------------------------------
# The camera for each of them is the scene's, and printing it needs no folder.
view=("$assets/blobs.vdb" --look plain --extinction 3 --luminance 1,0.6,0.2 --azimuth 35 --fov 40
  --resolution 64x48)
for format in json pbrt mitsuba blender vdb_render paraview; do
  for projection in perspective orthographic; do
    run 0 "3.87" "${view[@]}" --azimuth 0 --camera-position 3.87,2,4 --camera-for $format --projection $projection
    "$program" study "${view[@]}" --camera-for $format --projection $projection -q | grep '{[a-z_]*}' &&
      fail "--camera-for $format leaves a name open"
  done
done
"$program" study "${view[@]}" --camera-for json -q | python3 -m json.tool >/dev/null || fail "no JSON"
run 2 "pbrt" "${view[@]}" --camera-for maya
# A picture by psivox stands for another renderer's: the study finds the error that it measured
# itself, to the last digit, because the picture is the same. Over black, alpha is gone.
theirs=("${view[@]}" --step 1 --integrator midpoint --early-termination 6.103515625e-5 -q)
"$program" render "${theirs[@]}" -o their.exr
"$program" render "${theirs[@]}" -o opaque.exr --background 0,0,0
echo '[{"name": "peer fine", "picture": "../their.exr", "time_ms": 0.125}]' >whole/peers.json
others=("${view[@]}" --background 0,0,0 --samplings uniform --steps 1 --integrators midpoint
  --repeats 1 --no-split -q)
run 0 "" "${others[@]}" -o others --peers whole/peers.json --add "peer 2=their.exr,7.5" \
  --add over=opaque.exr
columns others renderer,rms,radiance_rms,alpha_rms,wall_ms_median | tr '\n' , | awk -F, '{
  # black leaves R, G and B as they are
  exit !($1 == "psivox" && $6 == "peer fine" && $7 == $2 && $8 == $3 && $9 == $4 &&
    $10 == 0.125 && $15 == 7.5 && $16 == "over" && $17 == $3 && $18 == $17 && $19 == "") }' ||
  fail "other renderers: $(columns others renderer,rms,radiance_rms,alpha_rms,wall_ms_median)"
grep -qF '"pictures/foreign_over.png":"iVBOR' others/index.html || fail "the page lacks a picture"
[ -s others/differences/foreign_peer_2.png ] || fail "no difference of another renderer"
run 0 "" "${others[@]}" -o others --resume --add late=their.exr
[ "$(columns others renderer | tr '\n' ,)" = "psivox,peer fine,peer 2,over,late," ] ||
  fail "resuming lost a picture: $(columns others renderer)"
run 2 "NAME=PICTURE" "${others[@]}" -o bad --add their.exr
run 2 "not a renderer's name" "${others[@]}" -o bad --add a/b=their.exr
run 2 "above 0" "${others[@]}" -o bad --add peer=their.exr,-1
run 2 "are named" "${others[@]}" -o bad --add peer=their.exr --add peer=opaque.exr
run 3 "no such file" "${others[@]}" -o bad --add peer=none.exr
run 3 "has 64x48 pixels; the study's pictures have 32x24" "${others[@]}" -o bad --add peer=their.exr --resolution 32x24
run 2 "unknown key 'time'" "${others[@]}" -o bad --peers <(echo '[{"name": "a", "picture": "b", "time": 1}]')
for json in '[{"name": "a",\n "picture": }]|line 2, column 13: ' '[{"name": 7, "picture": "b"}]|name: expected a text' \
  '[{"name": "a", "picture": "b", "time_ms": "x"}]|time_ms: expected a number'; do
  printf "${json%|*}" >peers.json
  run 2 "peers.json: " "${others[@]}" -o bad --peers peers.json
  grep -qF "${json#*|}" printed.txt && ! grep -q "json.exc" printed.txt || fail "$json: $(tail -n 1 printed.txt)"
done
run 2 "need a scene" --suite -o bad --add peer=their.exr
ln -s "$assets/blobs.vdb" blobs.0001.vdb
run 2 "one frame" blobs.####.vdb --frames 1 -o bad --add peer=their.exr
# vdb_render's camera is psivox's: at steps of half a voxel their pictures differ by less than 1e-3,
# and a camera that is off by a pixel by more than 1e-2.
if command -v vdb_render >/dev/null; then
  eval "$("$program" study "${view[@]}" --camera-for vdb_render -q) -step 0.5" >/dev/null 2>&1
  "$program" render "${view[@]}" --renderer reference -o truth.exr -q
  "$program" compare picture.exr truth.exr --max-rms 1e-3 || fail "vdb_render has another camera"
fi

[ ! -e bad ] || fail "a refused study leaves a folder"
[ $failed -eq 0 ] && echo "all passed"
exit $((failed > 0))
