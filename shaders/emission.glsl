// What a ray meets of the grids that emit. The medium's first is `emission`; a further one is a row of
// grids.glsl, and a line in each place here where its `name_channels` are above 0.
struct Emission {
  Track emission;
};

void aim_emission(INOUT(Emission) e, Pixel p) { e.emission = track_of(p, emission); }

// Moves the nodes to t. Returns the look-ups there.
int seek_emission(INOUT(Emission) e, real t) {
  e.emission.node = seek_node(emission_grid, e.emission, t);
  return look_ups(e.emission.node);
}

// What is emitted at t, where the nodes were sought [radiance / unit of t].
real3 emission_at(IN(Emission) e, real t) {
  return sample_grid(emission_grid, emission_channels, e.emission, t) * emission.scale;
}

// Where the ray, from t on, next leaves a cell, a run or the domain of one of them.
real emission_face(IN(Emission) e, real t) { return next_face(emission_grid, e.emission, t); }

// Their values along a piece of a cell.
struct EmissionPiece {
  Cubics emission;
};

EmissionPiece no_emission() { return EmissionPiece(constant_cubics(real3(real(0.0)))); }

// From t on, over a length in whose middle the nodes were sought.
EmissionPiece emission_along(IN(Emission) e, real t, real length) {
  return EmissionPiece(track_cubics(emission_grid, emission_channels, e.emission, t, length));
}

// What is emitted at `place` of the way through the piece, times a factor.
real3 emission_of(IN(EmissionPiece) piece, real place, real factor) {
  return polynomials(piece.emission, place) * (emission.scale * factor);
}
