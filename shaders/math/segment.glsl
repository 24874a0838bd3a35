// The input of an integrator: one segment of the ray, whose front end is nearer the camera.
struct Segment {
  real tau_front;   // attenuation at the front end [1 / unit of t]
  real tau_middle;  // at the middle; only where the rule reads it
  real tau_back;    // at the back end
  real extent;      // its length [unit of t]; glslang takes no member named `length`
  real depth;       // optical depth of the whole segment: exact under cells, of linear tau else
};

// The result of an integrator: radiance C = L_front front + L_middle middle + L_back back, and the optical
// depth that the rule gives the segment, zeta = e^{-depth}. front + middle + back = 1 - zeta must
// hold to rounding: then constant L gives exactly L (1 - T), the furnace test.
struct Weights {
  real front;
  real middle;
  real back;
  real depth;
};

// C = L_front (1 - Psi) + L_back (Psi - zeta) with the Psi of a homogeneous step (Moreland 2004,
// eq. 53 to 56), opacity = 1 - zeta. Psi - zeta: where Psi is near 1 as (1 - zeta) - (1 - Psi), both
// of which are small, else directly; 0 where a rule's Psi is below its zeta, so that no weight
// leaves [0, opacity].
Weights psi_weights(Homogeneous psi, real zeta, real opacity, real depth) {
  real back = psi.h > real(0.6) ? opacity - psi.one_minus_h : psi.h - zeta;
  back = max(back, real(0.0));
  return Weights(opacity - back, real(0.0), back, depth);
}

// Optical lengths of the two ends, x = tau * length, shifted so that their mean is the segment's
// depth: the linear model of a segment whose depth is known better than its ends tell. Shifted, not
// scaled: where both ends are next to 0 and the middle is not, their ratio is rounding.
struct Ends {
  real front;
  real back;
};

Ends shifted_ends(Segment s) {
  real front = s.tau_front * s.extent;
  real back = s.tau_back * s.extent;
  real shift = s.depth - real(0.5) * (front + back);
  // Where one end would be negative it is 0, the other this. Rounding of the look-ups can leave a
  // depth of -1e-16; no end is below 0 all the same.
  real most = max(real(2.0) * s.depth, real(0.0));
  return Ends(clamp(front + shift, real(0.0), most), clamp(back + shift, real(0.0), most));
}

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

// The entry of a table, from 0 to `last`, that holds a place; 0 for NaN.
int table_entry(real place, int last) { return place > real(0.0) ? int(min(place, real(last))) : 0; }
