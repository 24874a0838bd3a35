#!/usr/bin/env bash
# Tests sequences as their users render them: sequence_cli_test.sh PSIVOX MAKE_ASSETS. Without an
# EGL device it skips (exit 77).
tested=render make_assets=$2
. "$(dirname "$0")/cli_setup.sh"

# Files of a folder in one line, hidden ones too.
files() { (cd "$1" && find . -type f | sed 's|^\./||' | sort | tr '\n' ' ' | sed 's/ $//'); }
has() { [ "$(files "$1")" = "$2" ] || fail "$3: $1 has '$(files "$1")', expected '$2'"; }
same() { "$program" compare "$1" "$2" --max-abs 0 >/dev/null || fail "$3: $1 and $2 differ"; }
scene_of() { "$program" render --scene "$1" --print-scene -q; }

"$make_assets" --plume in 6 24 >/dev/null || exit 1
mkdir out other folder
small=(--resolution 48x32)
pattern=in/plume.####.vdb

# --- one choice for all frames --------------------------------------------------------------------
for look in auto plain; do
  rm -f out/*
  run 0 "6 frames" $pattern -o out/a.####.png "${small[@]}" --look $look
  has out "a.0001.png a.0002.png a.0003.png a.0004.png a.0005.png a.0006.png" "look $look"
  # the density grows tenfold; the scene does not change
  for frame in 2 3 4 5 6; do
    diff <(scene_of out/a.0001.png | grep -v '"input"') \
      <(scene_of out/a.000$frame.png | grep -v '"input"') || fail "frame $frame has another scene"
  done
done
run 0 "" $pattern -o other/a.%02d.png "${small[@]}" --look plain --frames 2-6x2
has other "a.02.png a.04.png a.06.png" "every second frame"
same out/a.0004.png other/a.04.png "a part of the frames"
rm other/*
run 0 "" in -o 'other/$F4.png' "${small[@]}" --look plain --frames 3
same out/a.0003.png other/0003.png "a folder"
run 0 "" in/plume.000{4,5,6}.vdb -o other/####.png "${small[@]}" --look plain --auto-from 4
has other "0003.png 0004.png 0005.png 0006.png" "several files"
cmp -s out/a.0004.png other/0004.png && fail "--auto-from chose what the whole sequence chooses"

# --- depths of another renderer, a file for each frame --------------------------------------------
mkdir depths held
run 0 "" $pattern -o 'depths/z.####.exr' "${small[@]}" --look plain --frames 1-2 --aov depth
run 0 "" $pattern -o 'held/a.####.exr' "${small[@]}" --look plain --frames 1-2 \
  --holdout 'depths/z.####.exr' --holdout-depth distance
scene_of held/a.0002.exr | grep -q 'z\.0002\.exr' || fail "frame 2 is held out by another frame"
"$program" render --scene held/a.0002.exr -o held/again.exr -q || fail "a frame that is held out again"
same held/a.0002.exr held/again.exr "a frame that is held out"
held=($pattern -o 'held/a.####.exr' "${small[@]}" --look plain --holdout 'depths/z.####.exr'
  --holdout-depth distance)
run 0 "2 frames stand" "${held[@]}" --frames 1-2 --resume
touch -d '1 hour' depths/z.0002.exr # depths that are newer than the picture
run 0 "1 frame stands" "${held[@]}" --frames 1-2 --resume
run 3 "has no file for: 3" "${held[@]}" --frames 1-3

# --- the frames of a scan -------------------------------------------------------------------------
mkdir scans
frame_values() { for _ in $(seq 216); do printf '%d ' "$1"; done; }
{
  printf 'NRRD0004\ntype: uchar\ndimension: 4\nsizes: 6 6 6 3\nencoding: text\n\n'
  frame_values 20 && frame_values 40 && frame_values 60
} >scan.nrrd
run 0 "3 frames" scan.nrrd -o 'scans/####.exr' "${small[@]}" --frames 0-2
has scans "0000.exr 0001.exr 0002.exr" "frames of a scan"
scene_of scans/0002.exr | grep -qF 'scan.nrrd[2]' || fail "frame 2 of a scan has another input"
"$program" render --scene scans/0002.exr -o again.exr -q || fail "a frame of a scan again"
same scans/0002.exr again.exr "a frame of a scan"
"$program" compare scans/0001.exr scans/0002.exr --max-abs 0 >/dev/null && fail "frames of a scan are one"
run 3 "has no frame [3] among its 3 grids" 'scan.nrrd[3]' -o out/none.exr
run 3 "3 frames have no file: 3-5; the files have frames 0-2" scan.nrrd -o 'out/none.####.exr' --frames 2-5
run 0 "3 frames stand" scan.nrrd -o 'scans/####.exr' "${small[@]}" --frames 0-2 --resume

# --- frames without a file ------------------------------------------------------------------------
mv in/plume.0003.vdb .
run 3 "1 frame has no file: 3" $pattern -o out/b.####.png "${small[@]}" --frames 2-4
run 3 "no file" $pattern -o out/b.####.png "${small[@]}" --frames 8-9 --missing skip
run 0 "1 frame has no file: 3" $pattern -o out/b.####.png "${small[@]}" --frames 2-4 --missing skip
[ ! -e out/b.0003.png ] || fail "a missing frame was drawn"
run 0 "the frame before is drawn" $pattern -o out/c.####.png "${small[@]}" --frames 2-4 --missing hold
same out/c.0002.png out/c.0003.png "--missing hold"
run 0 "1 frame has no file: 3" $pattern -o out/d.####.png "${small[@]}"
run 0 "look" in/plume.000{2,4,5}.vdb -o out/d.####.png "${small[@]}"
grep -q "no file" printed.txt && fail "files that were named one by one have gaps: $(cat printed.txt)"
mv plume.0003.vdb in

# --- frames that cannot be read -------------------------------------------------------------------
cp in/plume.0004.vdb kept.vdb
head -c 3000 kept.vdb >in/plume.0004.vdb
rm -f out/*
run 3 "plume.0004.vdb" $pattern -o out/a.####.png "${small[@]}" --auto-from 1,6
has out "a.0001.png a.0002.png a.0003.png" "a broken frame ends the rest"
run 3 "1 of 6 frames could not be read: 4" $pattern -o out/a.####.png "${small[@]}" --auto-from 1,6 \
  --keep-going
has out "a.0001.png a.0002.png a.0003.png a.0005.png a.0006.png" "--keep-going"
# it is the middle one, which chooses for all
rm -f out/*
run 3 "1 of 6 frames could not be read: 4" $pattern -o out/a.####.png "${small[@]}" --keep-going
has out "a.0001.png a.0002.png a.0003.png a.0005.png a.0006.png" "--keep-going with a broken middle"
# whoever draws other frames does without it
run 0 "2 frames" $pattern -o out/b.####.png "${small[@]}" --frames 1-2
run 3 "plume.0004.vdb" $pattern -o out/b.####.png "${small[@]}" --frames 1-2 --auto-from 4
cp kept.vdb in/plume.0004.vdb

# --- a frame without smoke is an empty picture ----------------------------------------------------
without_grids() { # FILE: a header and no grid
  printf ' BDV\0\0\0\0\340\0\0\0\12\0\0\0\0\0\0\0\1%s\0\0\0\0\0\0\0\0' \
    1a310b4b-f34f-4495-84eb-2ceb1c75b13d >"$1"
}
mv in/plume.0001.vdb kept.vdb
without_voxels() { "$make_assets" --empty "$1" >/dev/null; }
for make in without_voxels without_grids; do
  $make in/plume.0001.vdb
  rm -f out/*
  run 0 "" $pattern -o out/a.####.png "${small[@]}"
  [ -e out/a.0001.png ] || fail "an empty frame has no picture"
  [ "$("$program" render $pattern --print-scene -q)" = \
    "$("$program" render $pattern --print-scene -q --auto-from 2,4,6)" ] ||
    fail "the second frame does not stand for the first, which is empty"
  grep -q "frame 1: the picture is empty: grid 'density' has no active voxel" printed.txt ||
    fail "an empty frame is not named: $(cat printed.txt)"
done
# a notice comes once, with its frames
mv in/plume.0003.vdb kept.3.vdb
for frame in 1 3; do without_voxels in/plume.000$frame.vdb; done
run 0 "frames 1,3: the picture is empty: grid 'density' has no active voxel" $pattern -o out/a.####.png "${small[@]}"
[ "$(grep -c "is empty" printed.txt)" = 1 ] || fail "a notice of two frames comes twice: $(cat printed.txt)"
mv kept.3.vdb in/plume.0003.vdb
mv kept.vdb in/plume.0001.vdb

# --- resume ---------------------------------------------------------------------------------------
frames=($pattern -o out/a.####.png "${small[@]}")
run 0 "" "${frames[@]}"
cp -a out whole
rm out/a.0002.png
touch -d '1 hour' in/plume.0005.vdb # a volume that is newer than its picture
run 0 "4 frames stand" "${frames[@]}" --resume
diff -r out whole >/dev/null || fail "resumed: other pictures"
touch -d '1 hour ago' in/*
run 0 "6 frames stand" "${frames[@]}" --resume
run 0 "6 frames" "${frames[@]}" --resume --exposure 1
grep -q stand printed.txt && fail "pictures of another scene stand"
run 2 "cannot hold" $pattern -o out/a.####.hdr --resume
# a picture that is cut short, or of another format, does not stand
floats=($pattern -o out/f.####.exr "${small[@]}" --frames 1-2)
run 0 "" "${floats[@]}" --half
run 0 "" "${floats[@]}" --resume
grep -q stand printed.txt && fail "halves stand for floats"
head -c 3000 out/f.0001.exr >cut.exr && cp cut.exr out/f.0001.exr
run 0 "1 frame stands" "${floats[@]}" --resume
run 0 "" "${floats[@]}" --aov deep
head -c $(($(stat -c %s out/f.0002.exr) / 2)) out/f.0002.exr >cut.exr && cp cut.exr out/f.0002.exr
run 0 "1 frame stands" "${floats[@]}" --aov deep --resume
run 0 "" "${floats[@]}" --resume
grep -q stand printed.txt && fail "deep pictures stand for flat ones"

# --- one file is a frame, where the picture's name has a place for its number --------------------
run 0 "" in/plume.0002.vdb -o 'out/one.####.png' "${small[@]}"
[ -e out/one.0002.png ] || fail "the picture of one file has another number"
run 2 "'kept.vdb' has none" kept.vdb -o 'out/one.####.png'
run 3 "there is 'in/plume.0001.vdb'" 'in/plume.##.vdb' -o 'out/one.##.png'

# --- kill -9: the same pictures, and nothing else -------------------------------------------------
for delay in 0.15 0.5; do
  rm -rf out/*
  "$program" render "${frames[@]}" -q &
  pid=$!
  sleep $delay
  kill -9 $pid 2>/dev/null
  wait $pid 2>/dev/null
  run 0 "" "${frames[@]}" --resume
  diff -r out whole >/dev/null || fail "killed after $delay s and resumed: $(diff -r out whole)"
done

# --- signals: whole files, and the exit code that shells expect -----------------------------------
for signal in INT:130 TERM:143; do
  rm -rf out/*
  set -m # else background jobs ignore SIGINT
  "$program" render $pattern -o out/a.####.exr --resolution 400x300 --pixel-samples 4 -q &
  pid=$!
  for _ in $(seq 600); do
    [ -e out/a.0001.exr ] && break
    sleep 0.02
  done
  kill -${signal%:*} $pid
  wait $pid
  code=$?
  set +m
  [ $code -eq ${signal#*:} ] || fail "$signal: exit $code"
  if compgen -G 'out/.psivox*'; then fail "$signal: unfinished files"; fi
  for picture in out/*.exr; do
    "$program" compare "$picture" "$picture" >/dev/null || fail "$signal: $picture is broken"
  done
done

# --- two runs side by side do not harm each other -------------------------------------------------
rm -rf out/*
"$program" render "${frames[@]}" -q &
run 0 "" "${frames[@]}" --resume
wait $! || fail "side by side: exit $?"
diff -r out whole >/dev/null || fail "side by side: other pictures"

# --- cameras that move ----------------------------------------------------------------------------
rm -rf out/*
run 0 "4 frames" in/plume.0006.vdb -o out/t.#.png "${small[@]}" --turntable 4
has out "t.1.png t.2.png t.3.png t.4.png" "turntable"
run 2 "more than 1000000 frames" in/plume.0006.vdb -o out/t.#.png --turntable 2000000
run 2 "need files: -o FILE.####.png" in/plume.0006.vdb -o - --turntable 4
"$program" compare out/t.1.png out/t.3.png --max-abs 0.01 >/dev/null && fail "the camera does not turn"
run 0 "1 frame" in/plume.0006.vdb -o out/u.png "${small[@]}" --turntable 4 --frames 3
same out/t.3.png out/u.png "one picture of a turntable"
echo '{"keys": [{"frame": 1, "position": [0.5,1,6], "target": [0.5,1,0.5]},
                {"frame": 3, "position": [6,1,0.5]}]}' >path.json
run 0 "3 frames" in/plume.0006.vdb -o out/p.#.png "${small[@]}" --camera-path path.json
grep -q '6.0,' <(scene_of out/p.3.png | tr -d ' \n' | grep -o '"camera-position":\[[^]]*\]') ||
  fail "camera path: $(scene_of out/p.3.png | grep -A3 camera-position)"
for key in '"fov": 500' '"up": [0,0,0]' '"position": [1,2,3,4]'; do
  echo "{\"keys\": [{\"frame\": 1}, {\"frame\": 3, $key}]}" >bad.json
  run 3 "camera path 'bad.json': " in/plume.0006.vdb -o out/b.#.png "${small[@]}" --camera-path bad.json
done
echo '{"keys": [{"frame": 1, "position": [0.5,1,6]},
                {"frame": 3, "position": [0.5,8,0.5], "target": [0.5,1,0.5], "up": [0,1,0]}]}' >up.json
run 2 "--camera-path 'up.json', frame 3: --camera-up is parallel to the view" in/plume.0006.vdb \
  -o out/b.#.png "${small[@]}" --camera-path up.json
[ -z "$(ls out/b.* 2>/dev/null)" ] || fail "a path that ends upright: $(ls out)"
echo '{"keys": [}' >bad.json
run 3 "camera path 'bad.json': not a camera path in JSON: line 1, column 11" in/plume.0006.vdb -o out/b.#.png --camera-path bad.json
run 0 "6 frames" $pattern -o out/f.#.png "${small[@]}" --follow
[ "$(for i in 1 6; do scene_of out/f.$i.png | tr -d ' \n' | grep -o '"camera-target":\[[^]]*\]'; done | sort -u | wc -l)" = 2 ] ||
  fail "--follow: the camera stays"

# --- films ----------------------------------------------------------------------------------------
mkdir bin
cat >bin/ffmpeg <<'EOF'
#!/bin/sh
for last; do :; done
printf '%s\n' "$*" >ffmpeg.txt
cat >film.raw
wc -c <film.raw >"${last#file:}"
EOF
chmod +x bin/ffmpeg
PATH=$PWD/bin:$PATH run 0 "" $pattern -o out/m.#.png "${small[@]}" --movie film.mp4 --fps 30
[ "$(cat film.mp4)" = $((6 * 48 * 32 * 3)) ] || fail "film: $(cat film.mp4) bytes of pictures"
grep -q "48x32 -framerate 30" ffmpeg.txt || fail "film: $(cat ffmpeg.txt)"
run 2 "--fps is for --movie and --camera-path" $pattern -o out/m.#.png "${small[@]}" --fps 30
PATH=$PWD/bin:$PATH run 0 "" $pattern -o out/m.#.png "${small[@]}" --movie film.mp4 --resume
[ "$(cat film.mp4)" = $((6 * 48 * 32 * 3)) ] || fail "film of pictures that stand"
PATH=$PWD/bin:$PATH run 0 "" $pattern "${small[@]}" --movie alone.mp4
[ -s alone.mp4 ] || fail "a film alone"
mv film.raw alone.raw
# A folder's name is no protocol and no option of ffmpeg's, and never reaches it.
for folder in a:b http: file: -y '%d' "it's"; do
  mkdir -p "./$folder"
  PATH=$PWD/bin:$PATH run 0 "" $pattern "${small[@]}" --movie="$folder/x.mp4"
  [ -s "./$folder/x.mp4" ] || fail "no film in the folder $folder"
  grep -qF "$folder/x" ffmpeg.txt && fail "ffmpeg is given the name of the folder $folder"
done
PATH=$PWD/bin:$PATH run 0 "" $pattern -o out/m.#.png "${small[@]}" --movie film.mp4
cmp -s film.raw alone.raw || fail "a film alone has other frames than one of pictures"
# beside pictures to composite, and from them, a film has the look's background
for again in "" --resume; do
  PATH=$PWD/bin:$PATH run 0 "" $pattern -o out/x.#.exr "${small[@]}" --movie film.mp4 $again
  cmp -s film.raw alone.raw || fail "a film beside .exr $again: other pictures"
done
PATH=$PWD/bin:$PATH run 0 "" $pattern "${small[@]}" --movie film.mp4 --background '#ff4000'
[ "$(head -c 3 film.raw | od -An -tu1 | tr -d ' ')" = 255640 ] || fail "a film alone has no background"
if command -v ffmpeg >/dev/null; then # which calls a film that the disk cannot hold a success
  limited=$(ulimit -f 1 &&
    "$program" render $pattern "${small[@]}" --trust --movie film3.mp4 2>&1)
  [ $? -eq 5 ] || fail "a film beyond the limit of a file's size: $limited"
  [ ! -e film3.mp4 ] || fail "a film that was cut short is there"
fi
"$program" render --scene out/x.1.exr --print-scene -q | grep -q '"background": "none"' ||
  fail "a picture to composite has a background"
printf '#!/bin/sh\nexit 1\n' >bin/ffmpeg
PATH=$PWD/bin:$PATH run 5 "alone2.mp4" $pattern "${small[@]}" --movie alone2.mp4
[ ! -e alone2.mp4 ] || fail "a film that failed is there"
run 2 "expected .mp4" $pattern "${small[@]}" --movie film.gif
rm bin/ffmpeg
for tool in grep tail; do ln -s "$(command -v $tool)" bin; done
PATH=$PWD/bin run 5 "the same command and --resume makes it" $pattern -o out/m.#.png "${small[@]}" \
  --movie film2.mp4
PATH=$PWD/bin run 5 "ffmpeg, which is not installed" $pattern "${small[@]}" --movie film2.mp4
PATH=$PWD/bin run 2 "expected .mp4" $pattern -o out/m.#.png "${small[@]}" --movie film.gif
if compgen -G '.psivox*' || compgen -G 'out/.psivox*'; then fail "unfinished files"; fi

# --- a choice that is kept ------------------------------------------------------------------------
"$program" render $pattern -o out/k.#.png --frames 1 "${small[@]}" --print-scene -q >kept.json
run 0 "" --scene kept.json -o out/k.#.png --frames 5
run 0 "" $pattern -o out/l.#.png "${small[@]}" --frames 5
same out/k.5.png out/l.5.png "a scene that was printed"

# --- a study of all frames ------------------------------------------------------------------------
study=(study $pattern -o study --integrators midpoint,psi-balanced --samplings uniform --steps 2,1
  --repeats 1 --resolution 24x16 --no-split)
"$program" "${study[@]}" --frames 2,4,6 >printed.txt 2>&1 || fail "study: $(tail -n 2 printed.txt)"
grep -q "For 8 bits in all 3 frames" printed.txt || fail "study: $(cat printed.txt)"
has_all="$(ls study | tr '\n' ' ')"
[ "$has_all" = "frame.0002 frame.0004 frame.0006 frames.csv frames.json index.html " ] || fail "study: $has_all"
[ "$(wc -l <study/frames.csv)" = 5 ] || fail "study: $(wc -l <study/frames.csv) lines"
awk -F, 'NR > 1 { if (!($4 <= $3 && $3 <= $5 && $2 == 3 && $5 > 0)) exit 1 }' study/frames.csv ||
  fail "study: the RMS is not in order: $(cat study/frames.csv)"
scenes=$(for i in 2 4 6; do grep -o '"extinction": [^,]*' study/frame.000$i/results.json; done | sort -u | wc -l)
[ "$scenes" = 1 ] || fail "study: $scenes extinctions"

# --- statistics, and what is refused --------------------------------------------------------------
run 0 "" $pattern -o out/s.#.png "${small[@]}" --stats stats.json
grep -q '"waited"' stats.json || fail "statistics: no time of waiting"
[ "$(grep -c '"frame":' stats.json)" = 6 ] || fail "statistics: $(grep -c '"frame":' stats.json) frames"
run 2 "need a place for their number: -o 'a.####.png'" $pattern -o a.png
run 2 "is for a sequence" in/plume.0001.vdb -o a.png --resume
run 2 "one picture" $pattern -o a.#.png --check-error 10
run 2 "expected frames" $pattern -o a.#.png --frames 5-1
run 3 "no file matches" in/fire.####.vdb -o a.#.png
run 3 "no volume" folder -o a.#.png
run 5 "cannot write" $pattern -o nowhere/a.#.png

[ $failed -eq 0 ] && echo "sequences: all passed"
exit $((failed > 0))
