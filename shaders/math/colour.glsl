// IEC 61966-2-1: sRGB's code of linear light and the light of a code, both in [0, 1].
real srgb_from_linear(real light) {
  return light <= real(0.0031308) ? real(12.92) * light
                                  : real(1.055) * pow(light, real(1.0) / real(2.4)) - real(0.055);
}

real linear_from_srgb(real code) {
  return code <= real(0.04045) ? code / real(12.92)
                               : pow((code + real(0.055)) / real(1.055), real(2.4));
}

// K. Narkowicz, "ACES Filmic Tone Mapping Curve", knarkowicz.wordpress.com, 2016: a fit of ACES'
// transforms for sRGB displays, for each channel by itself. 0 stays 0, 1 becomes 0.80, 7.2 white.
real filmic(real light) {
  return light * (real(2.51) * light + real(0.03))
         / (light * (real(2.43) * light + real(0.59)) + real(0.14));
}

// The light of which filmic makes `shown`, at most 1: the root of a quadratic.
real filmic_inverse(real shown) {
  real a = real(2.51) - real(2.43) * shown;
  real b = real(0.03) - real(0.59) * shown;
  return (sqrt(b * b + real(0.56) * a * shown) - b) / (real(2.0) * a);
}

// Light of a display, 1 for white; more than 1 is to be cut. `curve` is a value of ToneMap. 0 for
// NaN.
real display_light(real radiance, int curve) {
  if (!(radiance > real(0.0))) return real(0.0);
  return curve == 1 ? filmic(min(radiance, real(1e4))) : radiance;
}
