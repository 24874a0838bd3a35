// IEC 61966-2-1: sRGB's code of linear light and the light of a code, both in [0, 1].
real srgb_from_linear(real light) {
  return light <= real(0.0031308) ? real(12.92) * light
                                  : real(1.055) * pow(light, real(1.0) / real(2.4)) - real(0.055);
}

real linear_from_srgb(real code) {
  return code <= real(0.04045) ? code / real(12.92)
                               : pow((code + real(0.055)) / real(1.055), real(2.4));
}
