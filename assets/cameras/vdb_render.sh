vdb_render {file} picture.exr -res {x}x{y} -camera {projection} \
@perspective -focal 50 -aperture {aperture} \
@orthographic -frame {width} \
-translate {position:,} -lookat {target:,} -up {up:,}{grid} \
-absorb 0,0,0 -scatter {per_voxel},{per_voxel},{per_voxel} -light 0,0,1,{luminance:,} \
-gain 0 -cutoff 0 -shadowstep 1e9
