#!/usr/bin/env bash
# Tests the program as its users call it: cli_test.sh PSIVOX ASSETS. Each line gives the exit code,
# a part of the output (or -), and the arguments. Without an EGL device it skips (exit 77).
tested= assets=$2
. "$(dirname "$0")/cli_setup.sh"

# t CODE TEXT ARGUMENTS...
t() {
  [ "$2" = - ] && set -- "$1" "" "${@:3}"
  run "$@"
}
S=$assets/blobs.vdb
R="--resolution 32x32 -q --look plain"

t 0 - render "$S" -o a.exr $R
t 0 - render "$S" -oa.exr $R
t 0 - render --output=a.exr --camera-position -1,2,300 $R "$S"
t 0 - render "$S" -o a.exr $R --camera-position=-.5,0,300 --camera-target -.5,0,1
# Reading in place draws the same picture.
t 0 - render "$S" -o b.exr $R --camera-position=-.5,0,300 --camera-target -.5,0,1 --trust
t 0 rms compare a.exr b.exr --max-abs 1e-30
t 0 "Reading is guarded by" --version
# Forms of help: shells read their completion, and manual pages have every exit code of the guide.
t 0 ".TH PSIVOX-RENDER 1" render --help=man
t 0 "_psivox() {" --help=bash
t 0 "#compdef psivox" --help=zsh
t 0 "complete -c psivox" study --help=fish
t 2 "expected one of man, bash, zsh, fish" --help=html
# completed WORD... WANTED: bash completes these words of a command line to those.
completed() {
  local found
  found=$(. <("$program" --help=bash) && COMP_WORDS=("$program" "${@:1:$#-1}") COMP_CWORD=$(($# - 1)) &&
    _psivox && echo "${COMPREPLY[*]}")
  [ "$found" = "${*: -1}" ] || fail "bash completes ${*:1:$#-1} to '$found'"
}
completed ver verify
completed render --mode = mi "mip minip"
completed render --mode "" "$("$program" --complete render --mode "" | xargs)"
completed view "$S" --orth "--ortho-width"
completed info "$S" ""
completed info "" ""
t 0 "--mode=isosurface" --complete render --mode=
t 0 "$(printf 'grid\tdensity grid')" --complete render --grid
# --help is short and ends with examples; --help-all has every option.
t 0 "psivox render --help-all prints all" render --help
t 0 "--end-corrections" render --help-all
t 0 "--extinction" help render
t 2 "unknown command" help rendr
# A file alone opens the window; without a display it says what to type.
said=$(env -u DISPLAY -u WAYLAND_DISPLAY "$program" "$S" 2>&1)
[ $? -eq 2 ] && grep -q "psivox render .*blobs.vdb -o FILE.png draws it" <<<"$said" || fail "file: $said"
said=$(env -u WAYLAND_DISPLAY DISPLAY=:none "$program" "$S" -q 2>&1)
grep -qE "no display for a window|there is no window" <<<"$said" || fail "file with a display: $said"
for command in render view info compare study verify examples; do
  lines=$("$program" help $command | tee help.txt | wc -l)
  { [ "$lines" -le 60 ] && tail -n 1 help.txt | grep -q "^  psivox $command" &&
    [ "$(grep -c '^  psivox' help.txt)" -eq 3 ]; } ||
    fail "help $command has $lines lines, and ends in: $(tail -n 1 help.txt)"
done
[ "$("$program" help render | grep -c '^  -')" -eq 15 ] ||
  fail "help render lists other than 15 options"
# Examples: the volume, and five pictures of it that differ.
t 0 "psivox render 'some ex/blobs.vdb' -o 'some ex/fire.png' --look fire" examples -o "some ex"
cmp -s "$S" "some ex/blobs.vdb" || fail "examples wrote another volume"
[ "$(cat "some ex"/*.png | wc -c)" -gt 100000 ] && [ "$(md5sum "some ex"/*.png | sort -uk1,1 | wc -l)" = 5 ] ||
  fail "examples drew: $(ls -l "some ex")"
__EGL_VENDOR_LIBRARY_FILENAMES=/dev/null t 4 "" examples -q -o quiet
! grep -q "psivox render" printed.txt || fail "examples -q prints $(<printed.txt)"
t 5 "" examples -o "$S/below"
# Thumbnails, also under a name without an extension.
cp "$S" thumbnail.png
t 0 - render "$S" -o thumbnail --thumbnail 48
cmp -s "$S" thumbnail.png || fail "a thumbnail without an extension took another file's place"
touch linked && chmod 600 linked && ln -s linked link
t 0 - render "$S" -o link --thumbnail 48
[ -L link ] && [ "$(stat -c %a linked)" = 600 ] && cmp -s thumbnail linked || fail "a thumbnail replaced a link, or changed a mode"
rm link && mkfifo thumbs
timeout 20 cat thumbs >piped &
t 0 - render "$S" -o thumbs --thumbnail 48
wait $!
[ -p thumbs ] && cmp -s thumbnail piped || fail "a thumbnail replaced a pipe"
t 0 rms compare thumbnail thumbnail
t 2 "--thumbnail needs a file" render "$S" --print-scene --thumbnail 48
t 2 "expected a whole number" render "$S" -o a.png --thumbnail 0
# A write beyond the limit of a file's size, as of a full disk, leaves the old picture and no other.
cp a.exr old.exr
said=$(ulimit -f 1 && "$program" render "$S" -o a.exr -q --look plain --resolution 64x64 2>&1)
code=$?
{ [ $code -eq 3 ] && grep -qF "larger than the limit of file sizes" <<<"$said"; } ||
  fail "limited size of shared memory: exit $code: $said"
limited=$(ulimit -f 1 &&
  "$program" render "$S" -o a.exr -q --trust --look plain --resolution 64x64 2>&1)
code=$?
{ [ $code -eq 5 ] && grep -qF "cannot write 'a.exr'" <<<"$limited" && cmp -s a.exr old.exr &&
  ! compgen -G '.psivox*' >/dev/null; } ||
  fail "limited size: exit $code: $limited"
# No file takes the place of a stream that is closed, and what was to be written there is an error.
said=$("$program" render "$S" -o - $R 2>&1 >&-)
code=$?
{ [ $code -eq 5 ] && [ "$said" != "" ]; } || fail "closed output: exit $code: $said"
"$program" render "$S" -o closed.exr $R <&- >&- 2>&- && "$program" compare closed.exr closed.exr >/dev/null ||
  fail "closed streams"
# A look that takes percentiles draws a grid of one value, too.
t 0 - render "$assets/slab.vdb" -o b.exr --resolution 32x32 -q --look scan
t 0 "isovalue 0.254, chosen by auto" render "$S" -o a.exr --mode isosurface --resolution 32x32
t 0 "--isovalue=0.25439453125, chosen by auto" render "$S" -o a.exr --mode isosurface --resolution 32x32 -v
t 2 "is a volume, not a scene" render --scene "$S" -o a.exr
t 0 "look colors" render "$S" -o a.exr --resolution 32x32 --grid color
t 0 "look vectors" render "$S" -o a.exr --resolution 32x32 --grid color --colormap hot
# A scene by a pipe draws the same.
t 0 - render "$S" -o a.exr $R --azimuth 20
"$program" render "$S" $R --azimuth 20 --print-scene | "$program" render --scene - -o b.exr -q
t 0 rms compare a.exr b.exr --max-abs 1e-30
edge=$assets/../../shared/data/edge
if [ -d "$edge" ]; then
  t 0 "nothing here can be rendered" info "$edge/empty.vdb"
  [ "$("$program" info "$edge/empty.vdb" | grep -cF "$edge/empty.vdb")" = 1 ] ||
    fail "info names an empty file twice"
  for odd in points background_one sphere_colour; do
    t 0 - render "$edge/$odd.vdb" -o odd.png --resolution 32x32 -q
    t 0 "auto:" info "$edge/$odd.vdb"
    ! "$program" info "$edge/$odd.vdb" | grep -qF "not usable" ||
      fail "info refuses $odd"
  done
  t 3 "--background-value 0" render "$edge/background_one.vdb" -o odd.png --strict
fi
t 0 "in 4 regions; the largest has" info --regions 4 "$assets/blobs.vdb"
t 0 '"imbalance"' info --regions 4 --json "$assets/blobs.vdb"
t 2 "--regions: expected" info --regions 0 "$assets/blobs.vdb"
# A look's background is for those who give none.
t 0 - render "$S" -o a.png --resolution 32x32 -q --look smoke
t 0 - render "$S" -o b.png --resolution 32x32 -q --look smoke --background none
t 7 - compare a.png b.png --max-rms 1e-3
# Planes.
t 0 - render "$S" -o a.exr $R --clip-plane -x=0.1
t 0 - render "$S" -o a.exr $R --clip -1,-1,-1,0.5,1,1 --clip-plane=0,0,0,1,1,0
t 0 - render "$S" -o a.exr $R --mode slice
t 0 - render "$S" -o a.exr $R --mode slice --slice y=0.3 --colormap gray
t 0 - render --scene a.exr -o b.exr -q
t 0 rms compare a.exr b.exr --max-abs 1e-30
t 0 - render "$S" -o b.exr $R --mode slice --slice y=0.3 --colormap gray --renderer reference
t 0 rms compare a.exr b.exr --max-abs 1e-30
t 2 "--slice is for --mode slice" render "$S" -o a.exr $R --slice z=3
t 2 "expected auto or an axis and a place such as z=3" render "$S" -o a.exr $R --mode slice --slice w
t 2 "the first three must be below the last three" render "$S" -o a.exr $R --clip 1,0,0,0,1,1
t 2 "leave out --clip" render "$S" -o a.exr $R --clip-plane x --sampling template --projection orthographic
t 2 "has no error to estimate" render "$S" -o a.exr $R --mode slice --check-error 10
# Cameras of files: what is exported draws the same again.
A="--azimuth 30 --elevation 20 --zoom 1.2"
t 0 - render "$S" -o a.exr $R $A --export-camera c.gltf
t 0 - render "$S" $A $R --export-camera c.pvcc
for camera in c.gltf c.gltf:psivox c.pvcc; do
  t 0 - render "$S" -o b.exr $R --camera $camera
  # The position is rounded to 1e-16 of itself and the turn is a quaternion. The picture moves by
  # less than 1e-12 pixels, so only float32's rounding of the rays remains, and the tolerance.
  t 0 rms compare a.exr b.exr --max-rms 1e-3
done
t 0 - render "$S" --up-axis z $R --export-camera z.gltf
t 0 - render "$S" --up-axis z -o a.exr $R
t 0 - render "$S" --up-axis z -o b.exr $R --camera z.gltf
t 0 rms compare a.exr b.exr --max-rms 1e-3
t 3 "has no camera 'other'; it has 'psivox'" render "$S" -o a.exr $R --camera c.gltf:other
t 2 "expected FILE.gltf" render "$S" -o a.exr $R --camera c.json
t 2 "writes one camera, and --follow moves it" render "$S" --turntable 2 --follow $R \
  -o 'a.#.png' --export-camera c.gltf
t 2 "written as .gltf or .pvcc" render "$S" $R --export-camera c.json
t 3 "cannot read camera" render "$S" -o a.exr $R --camera missing.gltf
echo '{"nodes": 3}' > bad.gltf
t 3 "" render "$S" -o a.exr $R --camera bad.gltf
t 2 "did you mean --step?" render "$S" -o a.exr --setp 1
t 2 "--step needs a value" render "$S" -o a.exr --step
t 2 - render "$S"
t 2 - render
t 2 - render -o a.exr
t 2 - render "$S" extra.vdb -o a.exr
t 2 "use .exr, .png, .tif, .tiff, .jpg, .jpeg, .hdr or .webp" render "$S" -o a.bmp
for output in -:png exr:-:exr jpg:-:jpg; do  # pipes
  "$program" render "$S" -o "${output%:*}" $R | cat >piped."${output##*:}"
  "$program" render "$S" -o whole."${output##*:}" $R
  cmp -s piped."${output##*:}" whole."${output##*:}" ||
    fail "-o ${output%:*} differs from a file"
done
t 2 "for itself" render "$S" -o - --stats - $R
t 2 "for itself" render "$S" -o - --print-scene $R
t 2 "use .exr" render "$S" -o bmp:- $R
t 2 "needs an .exr" render "$S" -o a.png --aov depth $R
t 2 "needs a .png or .tif" render "$S" -o a.exr --bits 16 $R
t 2 "needs a .png or .tif" render "$S" -o a.jpg --bits 8 $R
t 2 "{8,16}" render "$S" -o a.png --bits 10 $R
t 0 - render "$S" -o a.png --bits 16 $R
t 0 - render "$S" -o b.exr $R
# No output replaces an input, also not through a link, and no two options write one file.
cp "$S" volume.exr
ln -s volume.exr link.exr
t 0 - render "$S" -o a.exr $R
t 2 "is the input 'volume.exr'" render volume.exr -o volume.exr $R
t 2 "is the input 'volume.exr'" render volume.exr -o link.exr $R
t 2 "is the input 'volume.exr'" render volume.exr -o a.png --stats ./volume.exr $R
t 2 "is the input 'volume.exr'" render volume.exr --export-camera volume.exr $R
t 2 "is the input 'volume.exr'" render volume.exr -o link.exr --turntable 1 $R
t 2 "is also the file of -o" render "$S" -o b.exr --stats ./b.exr $R
t 2 "is the input 'a.exr'" compare a.exr a.exr --diff a.exr
t 2 "is the input 'volume.exr'" render "$S" -o a.exr --and "volume.exr scale=2" --stats volume.exr $R
cp "$S" volume
t 2 "is the input 'volume'" render volume -o volume --thumbnail 16
cmp -s "$S" volume && cmp -s "$S" volume.exr || fail "an input was replaced"
# What is read beside the volume, and what the header of a volume names.
"$program" render "$S" --export-camera cam.gltf $R
"$program" render "$S" --print-scene $R >scene.in.json
echo '{"background": "0,0,0"}' >look.json
echo '{"points": [{"value": 0, "attenuation": 1}, {"value": 1, "attenuation": 2}]}' >function.json
echo '{"keys": [{"frame": 1, "position": [0, 0, 9], "target": [0, 0, 0]}]}' >path.json
head -c 512 /dev/urandom >det.raw
printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nencoding: raw\ndata file: det.raw\n\n' >det.nhdr
mkdir before && cp cam.gltf scene.in.json look.json function.json path.json det.* a.exr before
for pair in "cam.gltf --camera" "scene.in.json --scene" "./look.json --look" "function.json --transfer-function" "path.json --camera-path"; do
  read -r input option <<<"$pair"
  t 2 "which it would replace" render "$S" -o f.exr --stats $input $option $input -q
done
t 2 "which it would replace" render "$S" -o a.exr --camera cam.gltf --export-camera cam.gltf $R
t 2 "is the input 'det.raw'" render det.nhdr -o a.exr --stats det.raw $R
t 2 "is the input 'a.exr'" render --scene a.exr -o b.exr --stats a.exr -q
mkdir study && cp a.exr study/reference.exr
t 2 "is the input 'study/reference.exr'" study "$S" -o study --add x=study/reference.exr $R --steps 1
cmp -s a.exr study/reference.exr || fail "a study replaced its input"
for file in before/*; do cmp -s $file "${file#before/}" || fail "$file was replaced"; done
t 0 - render --scene a.exr -o a.exr -q  # a picture may be drawn again in its place
# Pipes and devices are for the command line: a scene that names one would be read without end.
mkfifo pipe
for device in /dev/zero "$work/pipe"; do
  echo "{\"input\": \"$S\", \"transfer-function\": \"$device\"}" >endless.json
  "$program" render --scene endless.json -o a.exr -q >printed.txt 2>&1 &
  ended=$!
  for _ in $(seq 100); do kill -0 $ended 2>/dev/null || break; sleep 0.1; done
  kill $ended 2>/dev/null && fail "$device is read without end"
  grep -q "is a pipe or a device" printed.txt || fail "$device: $(<printed.txt)"
done
t 0 - render "$S" -o a.exr --transfer-function <(cat function.json) $R
# JSON that is nested deeper than the stack bears.
nested=$(head -c 200000 /dev/zero | tr '\0' '['; head -c 200000 /dev/zero | tr '\0' ']')
echo "$nested" | tee deep.tf.json >deep.gltf
echo "{\"extinction\": $nested}" >deep.json
echo "{\"steps\": $nested}" >deep.study.json
mkdir deep && cp deep.json deep/results.json
for deep in "2 --scene deep.json" "2 --look ./deep.json" "3 --transfer-function deep.tf.json" "3 --camera deep.gltf" "3 --camera-path deep.gltf"; do
  t ${deep%% *} "nested deeper than 200" render "$S" -o a.exr ${deep#* }
done
t 2 "nested deeper than 200" study "$S" -o study --study deep.study.json
t 3 "nested deeper than 200" study "$S" -o deep --resume --steps 1 $R
# Texts of a picture that unpack to gigabytes.
python3 - <<'END'
import struct, zlib
def chunk(kind, data):
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
text = zlib.compress(bytes(7900000).replace(b"\0", b"a"), 9)
with open("texts.png", "wb") as png:
    png.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 2, 1, 8, 2, 0, 0, 0)))
    for n in range(400):
        png.write(chunk(b"zTXt", b"k%d\0\0" % n + text))
    png.write(chunk(b"IDAT", zlib.compress(bytes(7))) + chunk(b"IEND", b""))
END
(ulimit -v 3000000 && "$program" compare texts.png texts.png >/dev/null) || fail "texts.png takes more than 3 GB"
# A table of gradients and points is counted before it is made.
list() { seq -s, "$1"; }
printf '{"gradients": [%s], "points": [%s]}' "$(list 4000)" \
  "$(seq 4000 | sed 's/.*/{"value": &, "attenuation": 1}/' | paste -sd,)" >wide.json
t 6 "the table of 4000 points at 4000 gradients takes" render "$S" -o a.exr --transfer-function wide.json --memory-limit 500M $R
# Outputs: a stranger's link in a folder for everybody is not followed; modes stay; what is not
# psivox's own unfinished file stays, and a pipe of such a name is not waited for.
touch .psivox-notes.tmp .psivox-1-2.tmp && mkfifo .psivox-1-0.tmp
cp a.exr mode.exr && chmod 600 mode.exr
t 0 - render "$S" -o mode.exr $R
[ "$(stat -c %a mode.exr)" = 600 ] || fail "the mode of an output changes to $(stat -c %a mode.exr)"
[ -e .psivox-notes.tmp ] && [ -p .psivox-1-0.tmp ] || fail "files of others were removed"
[ ! -e .psivox-1-2.tmp ] || fail "an unfinished file stays"
rm -f .psivox-*
if [ "$(id -u)" = 0 ]; then
  mkdir -m 1777 open && ln -s ../mode.exr open/link.exr && chown -h 65534 open/link.exr
  mkfifo open/page.html && chown 65534 open/page.html
  t 5 "Permission denied" render "$S" -o open/link.exr $R
  t 5 "Permission denied" render "$S" -o a.exr --stats open/page.html $R
fi
# Too little memory is no damage of a file.
said=$(ulimit -v 60000 && "$program" info "$S" 2>&1)
code=$?
{ [ $code -eq 6 ] || [ $code -eq 127 ]; } && [[ $said != *damaged* ]] || fail "60 MB: exit $code: $said"
said=$(ulimit -s 64 && "$program" info "$S" 2>&1)
[ $? -eq 6 ] || fail "a stack of 64 KiB: $said"
said=$(ulimit -d 130000 && "$program" render "$S" -o a.exr $R 2>&1)
[ $? -eq 6 ] || fail "130 MB of data: $said"
# Text of files never reaches a terminal as it is, nor a shell as code.
escape=$'a\x1b[2J\xc2\x9bm\xe2\x80\xae'
cp "$S" "$escape.vdb"
printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nencoding: raw\ndata file: %s\n\n' "$escape" >escape.nhdr
sed 's/density/$(id)>X/g; s/temperature/zz\x1b]0;zz\xc2\x9b\x07z/g; s/float/fl\x1b[m/g' "$S" >words.vdb
sed 's/density/$(id)>X/g; s/temperature/zzzzzzzzzzz/g' "$S" >shell.vdb
for call in "info $escape.vdb" "info --json $escape.vdb" "render $escape.vdb -o a.exr --grid $escape $R" \
  "render escape.nhdr -o a.exr" "info words.vdb" "info --json words.vdb" "info --regions 2 words.vdb" \
  "render words.vdb -o a.exr --grid nope" "render shell.vdb -o a.exr --resolution 8x8 -v --ocio $escape" \
  "render $S -o a.exr --mode $escape" "$escape" "render $escape.vdb -o a.exr --print-scene $R"; do
  "$program" $call >printed.txt 2>&1
  if LC_ALL=C grep -qP '[\x00-\x08\x0b-\x1f\x7f]|\xc2[\x80-\x9f]|\xe2\x80\xae' printed.txt; then
    fail "$call prints: $(head -c 300 printed.txt | od -c | head)"
  fi
done
"$program" info --json "$escape.vdb" | python3 -c 'import json, sys; json.load(sys.stdin)' || fail "escaped JSON"
line=$("$program" info shell.vdb | sed -n 's/^auto: //p')
eval "set -- $line"
[ ! -e X ] && [[ " $* " == *' --grid=$(id)>X '* ]] || fail "auto: $line"
t 0 - render "$S" -o a.exr --stats /dev/null $R
# 16 bits: half a code at the steepest slope of the sRGB curve, and half a code of alpha
t 0 rms compare a.png b.exr --max-abs 2.6e-5
t 0 - render "$S" -o a.tif --bits 16 --resolution 32x32 -q
t 0 '"background": [' render --scene a.tif --print-scene -q # of the look, as in a .png
t 0 - render "$S" -o a.tif --bits 16 $R
t 0 - render "$S" --emission-grid none --holdout none --environment none -o a.exr $R
t 0 rms compare a.tif b.exr --max-abs 2.6e-5
# Every other format, and what each keeps of the scene and of alpha.
t 0 - render "$S" -o a.tif $R
t 0 rms compare a.tif b.exr --max-abs 1e-30
for picture in a.tif a.jpg; do
  t 0 - render "$S" -o $picture $R
  t 0 - render --scene $picture -o a.exr -q
  t 0 rms compare a.exr b.exr --max-abs 1e-30
done
t 0 "'a.jpg' has no alpha: 1024 of 1024 pixels" render "$S" -o a.jpg --resolution 32x32 --look plain
# A file without options gets a look, which is stored and drawn again.
t 0 "look fire; -v prints its options" render "$S" -o a.png --resolution 32x32
t 0 "look fire: --background=" render "$S" -o a.png --resolution 32x32 -v
t 0 "not shown: temperature" render "$S" -o a.exr --resolution 32x32 --look smoke
t 0 - render --scene a.exr -o b.exr -q
t 0 rms compare a.exr b.exr --max-abs 1e-30
t 2 "did you mean smoke?" render "$S" -o a.png --look smok
t 0 - render "$S" -o a.hdr $R
t 3 "no psivox:scene" render --scene a.hdr -o a.exr -q
t 5 "at most 16383 pixels" render "$S" -o a.webp --resolution 16384x1
t 2 "dpeth not in {depth," render "$S" -o a.exr --aov dpeth $R
t 0 - render -o a.exr --aov depth "$S" --aov steps,samples $R
t 2 "excludes --quiet" render "$S" -o a.exr -q -v
t 0 - render "$S" -o a.exr --aov error,transmittance --renderer reference $R
t 0 - render "$S" -o a.exr --aov depth,transmittance,steps,samples $R
# A picture's scene has its layers, and finds its inputs from anywhere, also when all are moved.
channels() { "$program" render --scene "$1" -o layers.exr -q "${@:2}" && sed s,holdout-depth,,g layers.exr | grep -aoE 'transmittance|depth' | sort -u | tr '\n' ' '; }
[ "$(channels a.exr)" = "depth transmittance " ] || fail "layers are lost"
[ "$(channels a.exr --aov none)" = "" ] || fail "--aov none keeps layers"
t 0 - render --scene a.exr -o b.exr --renderer reference -q
mkdir -p project/data project/pictures elsewhere
cp "$S" project/data/v.vdb
cp "$assets/flame.json" project/data/
for picture in p.exr p.png p.tif; do
  t 0 - render project/data/v.vdb -o project/pictures/$picture --transfer-function project/data/flame.json $R
  cp project/pictures/$picture elsewhere/
  cd / || exit 1
  t 0 - render --scene "$work/project/pictures/$picture" -o "$work/b.exr" -q
  cd "$work" || exit 1
  t 0 - render --scene elsewhere/$picture -o b.exr -q
  cp -r project moved
  mv project hidden
  t 0 - render --scene moved/pictures/$picture -o b.exr -q
  mv hidden project
  rm -r moved
done
(cd project && "$program" render data/v.vdb --print-scene >pictures/scene.json)
t 3 - render --scene project/pictures/scene.json -o b.exr -q
cp project/pictures/scene.json project/
t 0 - render --scene project/scene.json -o b.exr --resolution 8x8 -q
for renderer in gl march-double reference; do
  t 0 - render "$S" -o $renderer.exr --renderer $renderer --sampling cells $R
done
t 0 rms compare gl.exr reference.exr --max-rms 1e-5
t 0 rms compare gl.exr march-double.exr --max-rms 1e-6 --max-abs 2e-5
t 2 "cells" render "$S" -o a.exr --integrator cell-exact --step 1 $R
# a tolerance, which is also the default
t 0 '"tolerance": 0.001' render "$S" -o loose.exr --stats - $R
t 0 rms compare loose.exr reference.exr --max-rms 1e-3
t 0 '"tolerance": 0.001' render "$S" -o a.exr --print-scene $R
t 0 rms compare loose.exr a.exr --max-abs 1e-30
# a picture whose writing takes seconds says so before
t 0 "writing 'wide.png'" render "$assets/single_voxel.vdb" -o wide.png --look plain --resolution 20000x501
rm -f wide.png
t 0 - render --scene loose.exr -o a.exr -q
t 0 rms compare loose.exr a.exr --max-abs 1e-30
t 0 '"tolerance": "none"' render "$S" --print-scene --step 1
t 0 '"tolerance": "none"' render --scene loose.exr --print-scene --step 1
t 0 '"method": "cells cell-exact"' render "$S" -o tight.exr --tolerance 2e-6 --stats - --luminance-grid color $R
# Exact cells have an error too, that of their arithmetic.
stats=$("$program" render "$S" -o tight.exr --tolerance 2e-6 --aov error --stats - --luminance-grid color $R)
grep -q '"layer_rms": [1-9]' <<<"$stats" || fail "the error of exact cells is 0"
t 0 "above --tolerance" render "$S" -o a.exr --tolerance 1e-12 --resolution 32x32
t 0 "estimate  RMS" render "$S" -o a.exr --tolerance 1e-2 --check-error 200 $R
t 0 "above the tolerance of 1e-12" render "$S" -o a.exr --tolerance 1e-12 --check-error 50 --resolution 32x32
t 0 - render "$S" -o whole.exr --mode isosurface --resolution 32x32 -q
t 0 "drawn in" render "$S" -o parts.exr --mode isosurface --resolution 32x32 --memory-limit 300K
t 0 rms compare whole.exr parts.exr --max-abs 1e-6
t 0 "200 pixels" render "$S" -o a.exr --step 4 --check-error 200 --resolution 20x10 -q
t 0 '"layer_rms"' render "$S" -o a.exr --tolerance 1e-2 --aov error --stats - $R
t 2 "itself" render "$S" -o a.exr --tolerance 1e-3 --step 1 $R
t 2 - render "$S" -o a.exr --check-error 0 $R
for filter in exact hardware; do
  t 0 - render "$S" -o $filter.exr --filter $filter --luminance-grid color $R
done
t 0 rms compare exact.exr hardware.exr --max-rms 1e-2
t 5 "no directory" render "$S" -o /nonexistent/a.exr $R
long=$(printf 'x%.0s' {1..300})
t 5 "File name too long" render "$S" -o a.exr --stats $long.json $R
t 5 "File name too long" render "$S" -o $long.html $R
t 5 "File name too long" study "$S" -o $long $R
ln -s circle.json circle.json
t 5 "symbolic links" render "$S" -o a.exr --stats circle.json $R
t 3 "no such file" render nope.vdb -o a.exr $R
t 3 "cannot read scene '/dev/zero': File too large" render --scene /dev/zero -o a.exr
t 3 "cannot be read from the standard input" render - -o a.exr $R
t 2 "no output; give -o a.png" render "$S" a.png $R
t 2 "psivox render b.vdb -o FILE.png draws it" b.vdb
t 0 "--renderer reference ignores --tolerance" render "$S" -o b.exr --renderer reference --tolerance 1e-4 --look plain --resolution 8x8
t 3 nope render "$S" -o a.exr --grid nope $R
t 3 nope render "$S" -o a.exr --luminance-grid nope $R
t 6 "over the limit of 0.00 MiB" render "$S" -o a.exr --memory-limit 2K $R
t 0 - render "$S" -o a.exr --memory-limit 100K $R
t 4 "--list-devices" render "$S" -o a.exr --device 99 $R
# Windows: numbers and percentiles, of maps, maxima, X-rays and the density; the scene keeps them.
for mode in alpha xray mip lmip; do
  t 0 - render "$S" -o a.exr --mode $mode --range 1%,99% --opacity 0:0,0.5:1 $R
  t 0 - render --scene a.exr -o b.exr -q
  t 0 rms compare a.exr b.exr --max-abs 0
done
t 0 '"range": [' render "$S" --print-scene --mode alpha --range 5%,95%
t 2 "goes from" render "$S" -o a.exr --range 99%,0.1 $R
t 3 "goes from 1 to 1" render "$assets/slab.vdb" -o a.exr --range 1%,99% $R
# A scale of the values: options stay in those of the file.
t 0 '"isovalue": 0.1' render "$S" --print-scene --value-scale log --mode isosurface --isovalue 0.1
t 0 "look scan" render "$S" -o a.png --value-scale log --range 1e-3,1 --resolution 320x180 --color-bar
t 2 "linear, log, symlog" render "$S" -o a.png --value-scale ln $R
# Several surfaces, with colours and opacities.
t 0 - render "$S" -o a.png --isovalue 0.1:orange:0.3,0.4 --resolution 64x64 -q
t 0 - render "$S" -o b.png --isovalue 0.4 --resolution 64x64 -q
t 7 - compare a.png b.png --max-rms 0.02
t 2 "such as 0.2:#ff8800:0.3,0.5" render "$S" -o a.png --isovalue 0.1:oranje $R
# The colour bar is in sRGB outputs alone, and in them opaque.
t 0 - render "$S" -o a.png --colormap viridis --color-bar --resolution 320x180 -q
t 0 - render "$S" -o b.png --colormap viridis --resolution 320x180 -q
t 7 - compare a.png b.png --max-rms 0.01
C="--camera-position 1,1,3 --resolution 320x180 -q"  # which nothing moves
t 0 - render "$S" -o a.png --scale-bar --resolution 320x180 -q
t 0 "too small" render "$S" -o a.png --scale-bar --resolution 40x30
# A picture's own depths hold out what is behind them.
t 0 - render "$S" -o whole.exr --aov depth --extinction 20 $R
t 0 - render "$S" -o a.exr --holdout whole.exr --holdout-depth distance --extinction 20 $R
t 7 - compare a.exr whole.exr --max-rms 0.05
t 0 - render --scene a.exr -o b.exr -q
t 0 rms compare a.exr b.exr --max-abs 0
t 3 "there is no such file" render "$S" -o a.exr --holdout none.exr $R
t 0 - render "$S" -o a.exr --holdout whole.exr --holdout-depth distance --resolution 32x32 -q
# Several volumes: what is wrong with one, and where they are not drawn.
t 0 - render "$S" -o a.exr --and "$S scale=0.5 translate=1,0,0" $R
mkdir -p moved && cp "$S" moved/first.vdb && cp "$S" moved/second.vdb
(cd moved && "$program" render first.vdb -o both.png --and "second.vdb scale=0.5" $R -q)
mv moved moved.again
t 0 - render --scene moved.again/both.png -o both.png
t 0 rms compare both.png moved.again/both.png --max-rms 1e-9
t 3 "none.vdb: no such file" render "$S" -o a.exr --and none.vdb $R
t 2 "is for one volume; leave out --and" study "$S" -o several --and "$S" -q
t 0 "the picture has no light" render "$S" -o a.exr --memory-limit 1500K --resolution 32x32
t 6 "only volumes without --and are drawn in parts" render "$S" -o a.exr --and "$S" --memory-limit 600K $R
t 2 "depths of one camera" render "$S" -o 'a.##.exr' --turntable 3 --holdout whole.exr $R
# A deep picture, and what it is not for.
t 0 '"deep_samples"' render "$S" -o deep.exr --aov deep --stats - $R
t 0 - render --scene deep.exr -o b.exr -q
cmp -s deep.exr b.exr || fail "a deep picture's scene draws another"
t 0 "deep samples a pixel" render "$S" -o a.exr --aov deep --pixel-samples 4 -v --resolution 32x32
t 3 "it is a deep image" compare deep.exr a.exr
t 0 '"bound_max"' render "$S" -o a.exr --aov bound --light 0,-1,0.2 --stats - $R
t 2 "is of integrals" render "$S" -o a.exr --aov bound --mode mip $R
t 2 "what a sky's directions miss" render "$S" -o a.exr --aov bound --sky 1,1,1 $R
t 0 '"bound_max"' render "$S" -o a.exr --aov bound --background 30,30,30 --stats - $R
t 2 "adds an error that --aov bound lacks" render "$S" -o a.exr --aov bound --half $R
t 6 "without layer bound" render "$S" -o a.exr --aov bound --memory-limit 300K --look plain $R
t 2 "--aov deep chooses --step itself" render "$S" -o a.exr --aov deep --step 1 $R
t 6 "needs the whole volume in one part" render "$S" -o a.exr --aov deep --memory-limit 300K --look plain $R
# A picture lights as the sky that it is; a map that is none is refused, as its options alone are.
t 0 - render "$S" -o map.exr --background 0.5,0.25,1.0 --resolution 32x16 --extinction 0 --look plain -q
t 0 - render "$S" -o a.exr --environment map.exr $R
t 0 - render "$S" -o b.exr --sky 0.5,0.25,1 $R
t 0 rms compare a.exr b.exr --max-abs 0
t 0 - render "$S" -o a.exr --environment map.exr --background environment $R
t 0 - render --scene a.exr -o b.exr -q
t 0 rms compare a.exr b.exr --max-abs 0
t 2 "give it too" render "$S" -o a.exr --environment-rotation 30 $R
t 2 "give it too" render "$S" -o a.exr --background environment $R
t 3 "has no grid" render "$S" -o a.exr --light 0,-1,0 --albedo-grid nowhere $R
t 0 - render "$S" -o a.exr --colormap viridis --color-bar $C
t 0 - render "$S" -o b.exr --colormap viridis $C
t 0 rms compare a.exr b.exr --max-abs 0
t 0 "too small" render "$S" -o a.png --colormap viridis --color-bar --resolution 40x30
t 2 "give --colormap" render "$S" -o a.png --color-bar $R
# Its title may be left out, before the volume too.
t 0 - render --colormap viridis --color-bar "$S" -o a.png --resolution 320x180 -q
t 0 - render --colormap viridis --color-bar 'temperature [K]' "$S" -o b.png --resolution 320x180 -q
t 7 - compare a.png b.png --max-abs 0.1
t 0 '"color-bar": "temperature [K]"' render --scene b.png --print-scene
t 0 '"color-bar": true' render --scene a.png --print-scene
# A vector's component has a map of its own.
t 0 - render "$S" -o a.png --grid color:x --color-bar --resolution 320x180 -q
# A look may bring the surface, and the map.
t 0 "look surface" render "$S" -o a.png --look surface --isovalue 0.3 --resolution 32x32
t 0 "look surface" render "$S" -o a.png --isovalue 0.3 --resolution 32x32
t 0 "look scan" render "$assets/ramp.vdb" -o a.png --color-bar --resolution 320x180
t 0 - render "$assets/ramp.vdb" -o b.png --resolution 320x180 -q
t 7 - compare a.png b.png --max-rms 0.01
# Maxima end at white by default, and at 1/4 of it over four times the range.
t 0 '"clipped_pixels": 0' render "$S" -o a.png --mode mip --stats - --resolution 32x32
t 0 - render "$S" -o a.exr --mode mip --range 0,1 $R
t 0 - render "$S" -o b.exr --mode mip --range 0,4 $R
f=$assets/isosurfaces.json
t 0 - render "$S" -o a.exr --transfer-function "$f" $R
t 0 - render "$S" -o a.exr --transfer-function "$f" --classification pre --integrator cell-exact $R
echo '{"points": [{"value": 0.5, "attenuation": 0, "color": [1, 0, 0]},
  {"value": 0.50001, "attenuation": 1, "color": [0, 1, 1]},
  {"value": 1, "attenuation": 1, "color": [1, 1, 0]}]}' >jump.json
t 0 "the table of --integrator preintegrated is off by up to 0.0" render "$S" -o a.exr \
  --resolution 32x32 --look plain --transfer-function jump.json --extinction 40 --step 1 \
  --integrator preintegrated
for wrong in "--mode mip" "--integrator preintegrated" "--integrator cell-exact" --split-knots; do
  t 2 "has gradients" render "$S" -o a.exr --transfer-function "$f" $wrong $R
done
t 0 - render "$S" -o a.exr --ortho-width 50 --projection orthographic --strict $R
t 0 - render "$S" -o b.exr --strict=false --scene a.exr $R
t 0 - compare a.exr b.exr --max-rms 0 --max-abs 0
t 0 - render --scene a.exr -o c.exr -q
t 0 - compare a.exr c.exr --max-rms 0 --max-abs=0
t 0 - render "$S" -o d.exr --luminance 2,1,1 $R
t 7 - compare a.exr d.exr --max-rms 1e-9
t 7 "diff  'diff.png': full colour from" compare d.exr a.exr --diff diff.png --max-rms 1e-9
t 0 rms compare diff.png diff.png
t 2 "use .exr, .png" compare a.exr d.exr --diff diff.bmp
t 2 "the numbers have the standard output" compare a.exr d.exr --diff -
t 3 - compare a.exr nope.exr
t 2 - compare a.exr b.exr --max-rsm 1
t 0 "all passed" verify
t 0 "wider" verify --filter hardware
t 0 '"passed": true' verify --json
t 2 "exact or hardware" verify --filter exakt
t 4 "--list-devices" verify --device 99
t 2 "unexpected argument" verify a.exr
# A wrong constant in a shader makes the verification fail.
cp -r "$assets/../shaders" broken && chmod -R u+w broken
sed -i 's/real(0.27) : real(0.73)/real(0.73) : real(0.27)/' broken/integrators/psi_weighted.glsl
PSIVOX_SHADER_DIR=$work/broken t 7 "beyond their bounds: ramp that glows, psi-weighted" verify
PSIVOX_SHADER_DIR=$work/broken t 7 '"passed": false' verify --json
# A picture's estimate includes the device's errors.
sed -i 's/real a = decay(m.optical_depth).a;/real a = real(0.9) * decay(m.optical_depth).a;/' broken/modes/light.glsl
PSIVOX_SHADER_DIR=$work/broken t 0 "by the device's arithmetic" render "$S" -o a.exr --resolution 32x32
echo '{"stpe": 1}' >bad.json
t 2 step render --scene bad.json -o a.exr
printf '{\n"step": 1,\n}' >broken.json
t 2 "broken.json: not a scene in JSON: line 3" render "$S" --scene broken.json -o a.exr
t 2 "unknown option --width; --resolution does that here" render "$S" -o a.exr --width 640
t 2 "unknown option --slice-axis; --slice does that here" render "$S" -o a.exr --slice-axis x
t 2 "unknown option --samples; --pixel-samples does that here" render "$S" -o a.exr --samples 4
t 2 "unknown option --density; --extinction does that here" view "$S" --density 2
t 2 "unknown option --width" compare a.exr b.exr --width 3
if "$program" compare a.exr b.exr --width 3 2>&1 | grep -q resolution; then
  fail "compare names an option that it does not have"
fi
t 3 "it has 'temperature' 'density' 'color'" render "$S" -o a.exr --grid tempreature
t 0 "\"isovalue\": [" render "$S" --print-scene --isovalue 0.2 --mode isosurface --isovalue 0.5
# What leaves the program: exposure, tone map, clipped pixels, and pictures that show nothing.
t 0 '"clipped_pixels": 0' render "$S" -o a.png --stats - $R
t 0 "exposure -3.21, chosen by auto" render "$S" -o a.png --luminance 9,9,9 \
  --background 0,0,0 --resolution 32x32 --exposure auto
t 0 '"exposure": -3.21' render --scene a.png --print-scene
t 0 "loses 1" render "$S" -o a.png --look plain --emission-grid temperature --emission-scale 0.001 --extinction 0.01 \
  --resolution 32x32
# A view of OpenColorIO; $OCIO alone changes nothing.
cat > small.ocio <<'OCIO'
ocio_profile_version: 1
strictparsing: false
roles: {default: light, scene_linear: light}
displays: {Screen: [!<View> {name: Plain, colorspace: shown}]}
colorspaces:
  - !<ColorSpace> {name: light}
  - !<ColorSpace> {name: shown, from_reference: !<ExponentTransform> {value: [0.5, 0.5, 0.5, 1]}}
OCIO
t 0 - render "$S" -o a.png $R
OCIO=small.ocio t 0 - render "$S" -o b.png $R
cmp -s a.png b.png || fail "OCIO alone changes a picture"
OCIO=small.ocio t 0 - render "$S" -o b.png --ocio-view Plain $R
cmp -s a.png b.png && fail "--ocio-view changes nothing"
t 0 '"ocio-display": "Screen"' render --scene b.png -o c.png --print-scene -q
cmp -s b.png c.png || fail "a view's metadata draw another"
t 0 - render "$S" -o a.exr --ocio none.ocio $R  # linear radiance has no view
# Transforms in a circle, a pipe in the place of a table, and a table that is an input.
sed 's/!<Exp.*/!<ColorSpaceTransform> {src: shown, dst: light}}/' small.ocio >circle.ocio
sed 's/!<Exp.*/!<FileTransform> {src: "endless.cube"}}/' small.ocio >endless.ocio
sed 's/!<Exp.*/!<FileTransform> {src: table.cube}}/; s/^roles/search_path: "luts:project"\n&/' small.ocio >table.ocio
mkfifo endless.cube
mkdir -p luts && { echo LUT_3D_SIZE 2; printf '0.5 0.5 0.5\n%.0s' {1..8}; } >luts/table.cube
t 3 "OpenColorIO crashes, or takes" render "$S" -o a.png --ocio circle.ocio $R
said=$(timeout 20 "$program" render "$S" -o a.png --ocio endless.ocio $R 2>&1)
[[ $said == *"which is a pipe or a device" ]] || fail "a config's pipe is waited for"
t 0 - render "$S" -o a.png --ocio table.ocio $R
t 2 "is the input 'luts/table.cube'" render "$S" -o a.png --ocio table.ocio --stats luts/table.cube $R
t 0 - render "$S" -o a.exr --exposure 3 --tone-map filmic $R  # linear radiance has neither
t 0 - render "$S" -o b.exr $R
t 0 rms compare a.exr b.exr --max-abs 0
r="--resolution 32x32"
# A notice that advises helps: with what it advises it is gone, and nothing advises what is given.
# advised TEXT ADVICE ARGUMENTS...
advised() {
  local text=$1 advice=$2
  shift 2
  t 0 "$text" render "$@" $r
  eval "set -- \"\$@\" $advice"
  "$program" render "$@" $r >printed.txt 2>&1 || fail "$advice ends in an error: $(cat printed.txt)"
  grep -qF -- "$text" printed.txt && fail "$advice does not make '$text' go: $(cat printed.txt)"
}
without() { # TEXT ARGUMENTS...
  local text=$1
  shift
  t 0 "" render "$@" $r
  grep -qF -- "$text" printed.txt && fail "$*: '$text' is said"
}
bright="-o a.png --luminance 9,9,9"
advised "brighter than white; --exposure auto" "--exposure auto" "$S" $bright --background 0,0,0
advised "brighter than white; --tone-map filmic" "--tone-map filmic" "$S" $bright --background 0,0,0 --exposure -2
without "; --" "$S" $bright --background 0,0,0 --exposure 1 --tone-map none --look plain --up-axis y \
  --grid density
without "brighter than white" "$S" -o a.png --look smoke --background white
without "brighter than white" "$S" -o a.png --look smoke --background white --exposure auto
advised "glow more than they cover, which alpha cannot hold; give --background" "--background 0,0,0" "$S" -o a.png \
  --look plain --emission-grid temperature --emission-scale 0.001 --extinction 0.01
advised "has no alpha" "--background 0.1,0.1,0.1" "$S" -o a.jpg --look plain
advised "so Y is; --up-axis z" "--up-axis z" "$S" -o a.png
advised "--grid NAME draws one of them" "--grid density" "$S" -o a.png --look plain
advised "not light an isosurface; --light X,Y,Z does" "--light 0,-1,0" "$S" -o a.exr --mode isosurface --sky 1,1,1 \
  --look plain
advised "800 K on; --temperature-scale" "--temperature-scale 2000" "$S" -o a.exr --temperature-grid density
advised "the picture shows only its background: what is seen is as bright as --background 1,1,1; --background black" "--background black" "$S" -o a.png \
  --look plain --extinction 1000 --background white
advised "makes all of it white; --exposure auto" "--exposure auto" "$S" -o a.png --look smoke --background 0.2,0.2,0.2 \
  --exposure 30
advised "narrower than a pixel; --zoom" '--zoom "$(sed -n "s/.*--zoom \([0-9.e+]*\) enlarges.*/\1/p" printed.txt)"' \
  "$S" -o a.exr --camera-position 1,2,3e6 --camera-target 13,12,12
for picture in a.png a.exr; do
  advised "the picture is black: its brightest light is 9.8e-07; --exposure auto" "--exposure auto" "$S" -o $picture --luminance 1e-6,0,0
done
advised "the picture is empty: nothing covers more than 9.1e-07 of a pixel; a larger --extinction" "--extinction 1" "$S" -o a.exr --look plain \
  --extinction 1e-6
advised "what is seen is as bright as --background 0.1,0.1,0.1; --background white" "--background white" "$S" \
  -o a.png --look plain --extinction 1000 --luminance 0.1,0.1,0.1 --background 0.1,0.1,0.1
# signed distances of a ball in air, as a CT has them, some without data, and beside them nothing
awk 'BEGIN {
  print "NRRD0004\ntype: float\ndimension: 3\nsizes: 12 12 12\nencoding: ascii\nspace: RAS\n"
  for (i = 0; i < 1728; ++i) {
    x = i % 12 - 6; y = int(i / 12) % 12 - 6; z = int(i / 144) - 6
    print x * x + y * y + z * z < 17 ? 40 + i : x < -3 && i % 2 ? -32768 : -1000 + i % 11
  }
}' >ball.nrrd
advised "values of -32768 taken as no data; --fill-value none" "--fill-value none" ball.nrrd -o a.png
awk 'BEGIN {
  print "NRRD0004\ntype: float\ndimension: 3\nsizes: 12 12 12\nencoding: ascii\nspace: RAS\n"
  for (i = 0; i < 1728; ++i) {
    x = i % 12 - 6; y = int(i / 12) % 12 - 6; z = int(i / 144) - 6
    print x * x + y * y + z * z < 17 ? 100 + i % 90 : 230
  }
}' >dark.nrrd
advised "230 fills the volume around the object, and is transparent; --opacity 0:0,1:1" "--opacity 0:0,1:1" dark.nrrd -o a.png
advised "chosen by auto; --isovalue 300 shows bone" "--isovalue 300" ball.nrrd -o a.png --mode isosurface
advised "Z is up (an NRRD scan of the space RAS); --up-axis y" "--up-axis y" ball.nrrd -o a.png
t 0 - render "$S" -o a.exr $r --export-camera away.gltf --camera-position 0,0,8 --camera-target 0,0,40
advised ", or give --camera-target" \
  '--camera-target "$(sed -n "s/.*--camera-target \([-0-9.e,+]*\).*/\1/p" printed.txt)"' \
  "$S" -o a.exr --camera away.gltf
t 0 "attenuates or glows; leave out the camera's options to see what is there" render "$S" -o a.exr $r --look plain \
  --zoom 30 --camera-target 1.2,1.7,1.1
t 0 "over the limit of 1.00 MiB for grids; raise --memory-limit or leave light out" render "$S" -o a.exr $r \
  --memory-limit 1M
! "$program" render "$S" -o a.exr $r --memory-limit 100M 2>&1 | grep -qF "has no light" ||
  fail "a larger --memory-limit leaves light out"
if [ -d "$edge" ]; then
  advised "leaves the shell out" '--clip "$(sed -n "s/.*--clip \([-0-9.e,+]*\) leaves.*/\1/p" printed.txt)"' \
    "$edge/nan_and_negatives.vdb" -o a.exr --opacity 0:1,1:1
fi
without ", or give --camera-target" "$S" -o a.exr --camera-position 0,0,300 --camera-target 0,0,400
t 0 "it is narrower than a pixel" render "$S" -o a.exr $r --zoom 1e-6
t 0 "the picture is empty: the camera looks past the volume" render "$S" -o a.exr $r \
  --camera-position 0,0,300 --camera-target 0,0,400
t 0 "the picture is empty: --isovalue 7 is not among the values of grid 'density', which go from 0 to" \
  render "$S" -o a.exr $r --mode isosurface --isovalue 7
t 0 "the picture is empty: --extinction is 0" render "$S" -o a.exr $r --extinction 0 --look plain
t 0 "the picture is black: --luminance is 0" render "$S" -o a.exr $r --luminance 0,0,0
t 0 "the picture is black: --albedo is 0" render "$S" -o a.exr $r --look plain --light 1,0,0 --albedo 0
t 0 "the picture is black: nothing in grid 'temperature' is hot enough" render "$S" -o a.exr $r \
  --temperature-grid temperature --temperature-scale 0.01
t 0 "hottest voxel has" render "$S" -o a.exr $r --temperature-grid temperature --temperature-scale 0.1
t 0 "the picture shows only its background: --exposure 0 makes all of it white; --exposure auto" \
  render "$S" -o a.png $r --background 30.0,30.0,30.0 --look plain --luminance 1.5,1.5,1.5
t 0 "the picture is empty: --clip leaves nothing of the volume, which lies from" render "$S" -o a.png $r \
  --clip 50,50,50,60,60,60
t 0 "the picture is empty: --clip-plane leaves nothing" render "$S" -o a.png $r --clip-plane x=50
t 0 "the picture is empty: --slice does not meet the volume" render "$S" -o a.png $r --mode slice \
  --slice z=50
t 0 "the picture is empty: no value of grid 'density'" render "$S" -o a.png $r --opacity 0:0,1:0 --look plain
# A name that is no UTF-8 is found again, from a picture too, though JSON must be UTF-8.
bytes=$(printf 'caf\xe9 \xef\x9e\x80.vdb')
cp "$assets/slab.vdb" "$bytes"
t 0 - render "$bytes" -o bytes.exr --look plain $R
t 0 - render --scene bytes.exr -o again.exr -q
t 0 rms compare bytes.exr again.exr --max-abs 0
# Values near the ends of float32: large ones are framed, small ones are missed, which is said.
for value in 1e37 1e-38; do
  printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 6 6 6\nencoding: ascii\n\n' >$value.nrrd
  printf "$value %.0s" {1..216} >>$value.nrrd
done
t 0 - render 1e37.nrrd -o a.exr $R
for power in 38 -30; do
  printf 'NRRD0004\ntype: float\ndimension: 4\nsizes: 3 6 6 6\nkinds: vector domain domain domain\nencoding: ascii\n\n' >vectors.nrrd
  printf "0.%se$power " {1..648} >>vectors.nrrd
  t 0 - render vectors.nrrd -o a.exr $r -q
  t 0 - render vectors.nrrd -o a.exr $R --value-scale log
done
t 0 "the picture is empty: the values of grid 'image', which go from 0 to 1e-38, are too small" \
  render 1e-38.nrrd -o a.exr $r --look plain
t 0 ", above --tolerance 0.001: the values of grid" render 1e-38.nrrd -o a.exr $r
echo '{"points": [{"value": 0, "attenuation": 0}, {"value": 1, "attenuation": 1e-320}]}' >faint.json
t 3 "give the transfer function larger ones" render "$S" -o a.exr $R --transfer-function faint.json
t 0 "the picture is black: --luminance-scale is 0" render "$S" -o a.png $r --luminance-grid density \
  --luminance-scale 0
t 0 "the picture is empty: --range begins at 5, not below" render "$S" -o a.png $r --mode mip --range 5,6
t 0 "the picture is black: the colour of --light or --sky is black" render "$S" -o a.png $r \
  --look plain --light 0,-1,0,black
# Colours: codes from 0 to 255 are recognised and said; light may be brighter than white.
t 0 - render "$S" -o a.png $R --background 0.2158605001138992,1,0
t 0 - render "$S" -o b.png $R --background '#80FF00'
t 0 rms compare a.png b.png --max-abs 0.004
t 0 "--background 128,255,0 is taken as #80ff00, codes from 0 to 255" render "$S" -o b.png $r --look plain \
  --background 128,255,0
t 0 rms compare a.png b.png --max-abs 0.004
t 0 "--luminance 255,128,0 is linear, where 1 is white; write #ff8000" render "$S" -o b.png $r \
  --luminance 255,128,0
t 0 "write 0,-1,0,#ff8000 for the codes" render "$S" -o b.png $r --light 0,-1,0,255,128,0
t 0 - render "$S" -o b.png $R --luminance orange --sky '#fff' --light camera:0,-1,0,rebeccapurple
t 2 "expected none or #rrggbb, a name of CSS" render "$S" -o b.png $R --background '#12345'
t 2 "expected none or #rrggbb, a name of CSS" render "$S" -o b.png $R --background oranje
# Other formats are named, with what reads them.
printf 'NRRD0005\n' >x.vdb
t 3 "x.vdb: its header has no 'type'" info x.vdb
printf '\037\213' >x.nii.gz
t 3 "x.nii.gz: is a damaged gzip" render x.nii.gz -o a.png
t 0 - render "$S" -o camera.exr $R
grep -qa worldToNDC camera.exr || fail "an EXR without the camera's attributes"
touch x.img
t 3 "x.img: holds the values of 'x.hdr'; give that file" render x.img -o a.png
printf '<?xml version="1.0"?>\n<VTKFile type="ImageData">' >y.vdb
t 3 "is a VTK file" render y.vdb -o a.png
{ head -c 128 /dev/zero; printf DICM; } >z.vdb
t 3 "is a DICOM image" render z.vdb -o a.png
for name in x.nii x.nrrd y.nvdb; do
  printf 'abcd' >$name
  t 3 "does not begin as a file of" render $name -o a.png
done
printf 'abcd' >x.vol
t 3 "x.vol: is a file of raw values" render x.vol -o a.png
printf 'abcd' >x
t 3 "x: begins as no volume that psivox reads" info x
printf 'abc' >x.raw
t 3 "is a file of raw values" render x.raw -o a.png
mkdir x.zarr
t 3 "is a Zarr array" render x.zarr -o a.png
t 3 "is a Zarr array" info x.zarr
mkdir scans
touch scans/1.dcm
t 3 "has no volume, but 'scans/1.dcm'; see docs/interchange.md" render scans -o a.png
t 2 "-o writes pictures; --movie x.mp4 writes a film" render "$S" -o x.mp4 --turntable 12
t 2 "several files are frames of a sequence: 2 frames need a place for their number: -o 'a.####.png'" \
  render "$S" "$assets/slab.vdb" -o a.png
for lit in "" "--mode isosurface" "--mode mip" "--temperature-grid temperature"; do
  ! "$program" render "$S" -o a.exr $r $lit 2>&1 | grep -q "the picture is" ||
    fail "a picture with $lit is called blank"
done
t 6 "65536x65536 takes 64.0 GiB of memory, and" render nope.vdb -o a.exr --resolution 65536x65536
t 2 - rendr
t 0 - --help
t 0 "OpenVDB" --version
t 0 '"extinction"' render "$S" --print-scene
t 0 temperature info "$S"
t 0 "density      float unknown, 0" info "$S"
t 0 "mean " info "$S"
t 0 "values not read" info "$S" --topology
t 0 "[world units]" info "$S"
t 0 "auto: --grid=density --extinction=" info "$S"
t 0 "look fire: --background=" info "$S"
t 0 '"look": "fire"' info "$S" --json
# What info says is what render draws.
diff <("$program" render "$S" --print-scene -q | tr -d '\n ' | grep -oE '"(extinction|emission-scale)":[^,]*' | sort) \
  <("$program" info "$S" --json | tr -d '\n ' | grep -oE '"(extinction|emission-scale)":[^,]*' | sort) ||
  fail "info and render choose different looks"
t 0 '"world_box"' info "$S" --json
t 0 '"mean"' info "$S" --json
t 0 '"up-axis": "y"' info "$S" --json
t 0 '"name"' info "$S" --json
t 0 '"samples_per_ray"' render "$S" -o a.exr --stats - --resolution 32x32
t 0 samples render "$S" -o a.exr -v --resolution 32x32
if compgen -G '.psivox*' >/dev/null || [ -e a.bmp ]; then
  fail "a half-written file was left"
fi

# The window without a display, and options refused before a window opens.
DISPLAY="" WAYLAND_DISPLAY="" t 4 "psivox render" view "$S"
t 2 "{native,egl}" view "$S" --context glx
t 2 "at least 0" view "$S" --frame-budget fast
t 2 "--benchmark-orbit: expected a whole number at least 2" view "$S" --benchmark-orbit 1
t 2 "no input" view --benchmark-orbit 10
t 2 "did you mean --watch?" view "$S" --wacht
t 0 "--frame-budget" view --help-all
t 2 "expected a number at least 0, not 'nan'" view "$S" --frame-budget nan
if "$program" view --help-all | grep -q benchmark; then
  fail "--help lists hidden options"
fi

# The program loads the modules of OpenVDB and OpenImageIO on demand. Without one it prints a line.
mkdir -p alone/psivox
library=$(ldd "$program" | awk '/libpsivox/ { print $3 }')
cp -L "$library" alone/libpsivox.so.0
LD_LIBRARY_PATH=alone t 3 "cannot load the module with OpenVDB: alone/psivox/libpsivox_reader.so" \
  render "$S" -o alone.exr $R
cp -L "${library%/*}/psivox/libpsivox_reader.so" alone/psivox
missing="psivox: cannot load the module that reads and writes pictures: alone/psivox/libpsivox_oiio.so"
for picture in alone.exr alone.png; do
  LD_LIBRARY_PATH=alone t 0 - render "$S" -o $picture $R
  LD_LIBRARY_PATH=alone t 0 rms compare $picture $picture
  LD_LIBRARY_PATH=alone t 0 '"input"' render --scene $picture --print-scene
done
LD_LIBRARY_PATH=alone t 5 "$missing" render "$S" -o alone.tif $R
t 0 - render "$S" -o other.tif $R
LD_LIBRARY_PATH=alone t 1 "$missing" compare other.tif other.tif
LD_LIBRARY_PATH=alone t 0 "OpenImageIO none (${missing#psivox: }" --version
[ ! -e alone.tif ] || fail "alone.tif was written"

# EGL finds no driver.
output=$(__EGL_VENDOR_LIBRARY_FILENAMES=/dev/null "$program" render "$S" -o n.exr $R 2>&1)
code=$?
if [ $code -ne 4 ] || ! grep -q install <<<"$output"; then
  fail "without a driver: exit $code, $output"
fi

# Mesa with too old an OpenGL. Other drivers do not know the variable.
renderer=$("$program" --version | sed -n 's/^GL \(.*\), 4\..*Mesa.*/\1/p')
if [ -n "$renderer" ]; then
  MESA_GL_VERSION_OVERRIDE=3.3 t 4 "4.5 core is needed; $renderer" render "$S" -o n.exr $R
fi

[ $failed -eq 0 ]
