// The field along one cell, between its entry (s = 0) and exit (s = 1): the cubic through the
// values at 0, 1/2 and 1 whose third-order coefficient the corners give,
//   f(s) = f_0 + s (q_1 + s (q_2 + s q_3)).
struct Cubic {
  real f_0;
  real q_1;
  real q_2;
  real q_3;
};

Cubic make_cubic(real f_0, real f_half, real f_1, real q_3) {
  real q_2 = real(2.0) * (f_0 - real(2.0) * f_half + f_1);
  real q_1 = f_1 - f_0 - q_2;
  return Cubic(f_0, q_1 + real(0.5) * q_3, q_2 - real(1.5) * q_3, q_3);
}

// Terms are summed in pairs, since a turn waits for the longest chain of operations.
real polynomial(Cubic c, real s) { return (c.f_0 + s * c.q_1) + (s * s) * (c.q_2 + s * c.q_3); }

// An attenuation: rounding must not make it negative.
real evaluate(Cubic c, real s) { return max(polynomial(c, s), real(0.0)); }

// The same cubic from its other end.
Cubic reversed(Cubic c) {
  return Cubic(c.f_0 + c.q_1 + c.q_2 + c.q_3, -c.q_1 - real(2.0) * c.q_2 - real(3.0) * c.q_3,
               c.q_2 + real(3.0) * c.q_3, -c.q_3);
}

// Where a cubic turns inside (0, 1), in order; 1 where it does not.
struct Turns {
  real first;
  real second;
};

Turns turning_points(Cubic c) {
  // 3 q_3 s^2 + 2 q_2 s + q_1 = 0, without cancellation; a quotient by 0 or beyond is no turn
  real discriminant = max(c.q_2 * c.q_2 - real(3.0) * c.q_3 * c.q_1, real(0.0));
  real root = sqrt(discriminant);
  real q = -(c.q_2 + (c.q_2 < real(0.0) ? -root : root));
  real a = real(3.0) * c.q_3;
  real u = abs(q) < abs(a) ? q / a : real(1.0);
  real v = abs(c.q_1) < abs(q) ? c.q_1 / q : real(1.0);
  u = u > real(0.0) ? u : real(1.0);
  v = v > real(0.0) ? v : real(1.0);
  bool turns = discriminant > real(0.0);
  return Turns(turns ? min(u, v) : real(1.0), turns ? max(u, v) : real(1.0));
}

// Where c - target changes its sign between lo and hi, over which c is monotone. Bisects to 2^-20 if
// that is wanted; a group of lanes leaves at once if no lane wants it.
real bisect(Cubic c, real target, real lo, real hi, bool wanted) {
  bool below = polynomial(c, lo) < target;
  int steps = wanted ? 20 : 0;
  for (int i = 0; i < steps; ++i) {
    real middle = real(0.5) * (lo + hi);
    if ((polynomial(c, middle) < target) == below) lo = middle;
    else hi = middle;
  }
  return hi;
}

// The first turn that c reaches by a change of more than `noise`; 1: there is none.
real first_turn(Cubic c, real noise) {
  Turns turn = turning_points(c);
  real second = abs(polynomial(c, turn.second) - c.f_0) > noise ? turn.second : real(1.0);
  return abs(polynomial(c, turn.first) - c.f_0) > noise ? turn.first : second;
}

// The first part of [0, 1] over which c stays between low and high, where it begins.
real first_exit(Cubic c, real low, real high) {
  Turns turn = turning_points(c);
  real f_1 = polynomial(c, turn.first);
  real f_2 = polynomial(c, turn.second);
  real f_3 = polynomial(c, real(1.0));
  bool in_1 = f_1 >= low && f_1 <= high;
  bool in_2 = f_2 >= low && f_2 <= high;
  real f = !in_1 ? f_1 : !in_2 ? f_2 : f_3;
  bool left = f < low || f > high;
  real lo = !in_1 ? real(0.0) : !in_2 ? turn.first : turn.second;
  real hi = !in_1 ? turn.first : !in_2 ? turn.second : real(1.0);
  real s = bisect(c, f > high ? high : low, lo, hi, left);
  return left ? s : real(1.0);
}

// Integral of f from 0 to s.
real antiderivative(Cubic c, real s) {
  return s * ((c.f_0 + (s * real(0.5)) * c.q_1)
              + (s * s) * (real(1.0 / 3.0) * c.q_2 + (s * real(0.25)) * c.q_3));
}

// Greatest Bernstein coefficient, which no value on [0, 1] exceeds. Trilinear data without negative
// values has no negative coefficient, and f's mean is the mean of the coefficients.
real greatest_coefficient(Cubic c) {
  real b_1 = c.f_0 + c.q_1 / real(3.0);
  real b_2 = c.f_0 + (real(2.0) * c.q_1 + c.q_2) / real(3.0);
  real b_3 = c.f_0 + c.q_1 + c.q_2 + c.q_3;
  return max(max(c.f_0, b_1), max(b_2, b_3));
}

// The cubic of [0, part], stretched to [0, 1].
Cubic first_part(Cubic c, real part) {
  return Cubic(c.f_0, c.q_1 * part, c.q_2 * part * part, c.q_3 * part * part * part);
}

// Part of [0, 1], from 0 on, over which x f integrates to at most `most`. Each of the four
// terms of p x (f_0 + q_1 p + q_2 p^2 + q_3 p^3), the negative ones left out, may have a quarter of
// it. What a part shorter than 1 holds is at least 1/60 of that quarter for a cubic that is not
// negative (worst case s -> (1 - s)(s - 1/3)^2), which bounds the number of parts of a ray.
real shallow_part(Cubic c, real x, real most) {
  if (x * greatest_coefficient(c) <= most) return real(1.0);
  real quarter = real(0.25) * most / x;
  real none = real(1e-37);
  real p_0 = quarter / max(c.f_0, none);
  real p_1 = sqrt(quarter / max(c.q_1, none));
  real p_2 = pow(quarter / max(c.q_2, none), real(1.0 / 3.0));
  real p_3 = sqrt(sqrt(quarter / max(c.q_3, none)));
  return min(min(min(p_0, p_1), min(p_2, p_3)), real(1.0));
}

Cubic scaled(Cubic c, real factor) {
  return Cubic(c.f_0 * factor, c.q_1 * factor, c.q_2 * factor, c.q_3 * factor);
}

Cubic sum_of(Cubic a, Cubic b) {
  return Cubic(a.f_0 + b.f_0, a.q_1 + b.q_1, a.q_2 + b.q_2, a.q_3 + b.q_3);
}

// The product of two cubics is low(s) + s^4 high(s).
Cubic product_low(Cubic a, Cubic b) {
  return Cubic(a.f_0 * b.f_0, a.f_0 * b.q_1 + a.q_1 * b.f_0,
               a.f_0 * b.q_2 + a.q_1 * b.q_1 + a.q_2 * b.f_0,
               a.f_0 * b.q_3 + a.q_1 * b.q_2 + a.q_2 * b.q_1 + a.q_3 * b.f_0);
}

Cubic product_high(Cubic a, Cubic b) {
  return Cubic(a.q_1 * b.q_3 + a.q_2 * b.q_2 + a.q_3 * b.q_1, a.q_2 * b.q_3 + a.q_3 * b.q_2,
               a.q_3 * b.q_3, real(0.0));
}
