// Radiance of an emission that is quadratic along a segment, seen from its front through a constant
// attenuation of optical depth x: weights of its front, middle and back value, times the length.
// From the moments M_n = integral over [0,1] of u^n e^{-x u}; x = 0 is Simpson's rule.
#if REAL_BITS == 64
const int glow_terms = 18;
#else
const int glow_terms = 10;
#endif

Weights glow_weights(real x) {
  real m_0 = real(0.0);
  real m_1 = real(0.0);
  real m_2 = real(0.0);
  if (x < real(1.0)) {
    // (-x)^n / n! / (n + k + 1); the first term left out is 1e-8 of the sum
    real term = real(1.0);
    for (int n = 0; n < glow_terms; ++n) {
      m_0 += term / real(n + 1);
      m_1 += term / real(n + 2);
      m_2 += term / real(n + 3);
      term = -term * x / real(n + 1);
    }
  } else {
    Decay d = decay(x);
    m_0 = d.a / x;
    m_1 = (m_0 - d.e) / x;
    m_2 = (real(2.0) * m_1 - d.e) / x;
  }
  return Weights(real(2.0) * m_2 - real(3.0) * m_1 + m_0, real(4.0) * (m_1 - m_2),
                 real(2.0) * m_2 - m_1, x);
}
