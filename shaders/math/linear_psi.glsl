// A segment of linear attenuation that grows, carried on for ever from one of its ends:
//   V = integral of e^{-x u - w^2 u^2/4},  U = integral of u e^{-x u - w^2 u^2/4},  u from 0 on,
// x the optical length at that end, w^2 = 2 (x_b - x_f). With p = x/w and e = sqrt(pi) erfcx(p),
// V = e/w, U = 2 (1 - p e)/w^2; here as Mills' ratio e = 1/(p + r), so that neither difference is
// formed and w may be 0, the homogeneous medium:
//   V = 1/(x + w r),  U = 2 (r/w) V.
struct Tail {
  real v;
  real u;
};

// rho = r (p + sqrt(pi)/2), which is 1/2 at p = 0 and for ever, as a Chebyshev sum in
// y = (p - 3)/(p + 3), written as a polynomial. Numbers: tools/fit_psi.py.
real mills_rho(real y) {
#if REAL_BITS == 64  // degree 22, relative error 5.0e-14
  real s = real(-2.8240447669247715e-07);
  s = (y * s + real(-1.2116212655399750e-07)) * y + real(2.8409760197689593e-06);
  s = (y * s + real(1.0141633255411620e-07)) * y + real(-1.4873120378400273e-05);
  s = (y * s + real(6.7441930775569148e-06)) * y + real(5.3916077642962579e-05);
  s = (y * s + real(-5.8616628498361911e-05)) * y + real(-1.4319285957230948e-04);
  s = (y * s + real(2.9764659381624654e-04)) * y + real(2.2876672539619454e-04);
  s = (y * s + real(-1.1114755561610922e-03)) * y + real(2.3758839625507818e-04);
  s = (y * s + real(3.1212230917913479e-03)) * y + real(-3.6703675205578851e-03);
  s = (y * s + real(-5.3865935040846597e-03)) * y + real(1.6805296293034721e-02);
  s = (y * s + real(-5.1773512368403595e-03)) * y + real(-4.3157961508346623e-02);
  s = (y * s + real(9.0501780229843917e-02)) * y + real(-6.0569613510003181e-02);
  s = (y * s + real(-8.2193337437170126e-02)) * y + real(5.9022788245498107e-01);
#else  // degree 12, 6.8e-08
  real s = real(-1.11648335e-05);
  s = (((y * s + real(-4.58010935e-04)) * y + real(4.74828951e-04))
      * y + real(2.42074132e-03)) * y + real(-3.80535294e-03);
  s = (((y * s + real(-4.99866482e-03)) * y + real(1.68475278e-02))
      * y + real(-5.28512527e-03)) * y + real(-4.31644876e-02);
  s = (((y * s + real(9.05148214e-02)) * y + real(-6.05692271e-02))
      * y + real(-8.21937925e-02)) * y + real(5.90227879e-01);
#endif
  return s;
}

Tail growing_tail(real x, real w) {
  real rho = mills_rho((x - real(3.0) * w) / (x + real(3.0) * w));
  real g = rho / (x + real(0.8862269254527580) * w);  // r/w
  real v = real(1.0) / (x + w * w * g);
  return Tail(v, real(2.0) * g * v);
}

// The same for attenuation that falls, w^2 = 2 (x_f - x_b), where the integrals do not exist but
// their continuations do: with Dawson's integral F(p) = e^{-p^2} int_0^p e^{t^2} dt, p = x/w and
// N = 2 p F - 1,
//   V = 2 F/w = (1 + N)/x,  U = 2 N/w^2.
// F from 2 on by way of N, so that N keeps its relative precision as it falls like 1/(2 p^2).
// Chebyshev sums, written as polynomials. Numbers: tools/fit_psi.py.

real dawson_near(real y) {  // F/p of p to 2, y = p^2/2 - 1
#if REAL_BITS == 64  // degree 17, relative error 6.1e-17
  real s = real(-1.1706136060496419e-11);
  s = (y * s + real(1.0302958486363423e-10)) * y + real(-8.0624207310364682e-10);
  s = (y * s + real(6.2748760285002980e-09)) * y + real(-4.5799448906980178e-08);
  s = (y * s + real(3.1094845579122954e-07)) * y + real(-1.9566106886081958e-06);
  s = (y * s + real(1.1341494950977554e-05)) * y + real(-6.0123019423493013e-05);
  s = (y * s + real(2.8899985563771982e-04)) * y + real(-1.2466956447363759e-03);
  s = (y * s + real(4.7658048986450861e-03)) * y + real(-1.5891236064195323e-02);
  s = (y * s + real(4.5294720543522322e-02)) * y + real(-1.0747975160584992e-01);
  s = (y * s + real(2.0497987582912600e-01)) * y + real(-2.9998509320676117e-01);
  s = y * s + real(3.1999403728270447e-01);
#else  // degree 10, 1.3e-08
  real s = real(1.23109302e-05);
  s = (((y * s + real(-6.57328118e-05)) * y + real(2.87895351e-04))
      * y + real(-1.24100850e-03)) * y + real(4.76638123e-03);
  s = (((y * s + real(-1.58937412e-02)) * y + real(4.52945850e-02))
      * y + real(-1.07479302e-01)) * y + real(2.04979887e-01);
  s = (y * s + real(-2.99985116e-01)) * y + real(3.19994037e-01);
#endif
  return s;
}

real dawson_middle(real y) {  // 2 p^2 N of p from 2 to 4, y = p - 3
#if REAL_BITS == 64  // degree 20, relative error 6.5e-14
  real s = real(1.9272791895730279e-07);
  s = (y * s + real(2.1143875672535728e-07)) * y + real(-3.2017963795816229e-06);
  s = (y * s + real(3.0495331132529557e-06)) * y + real(1.9121805864719121e-05);
  s = (y * s + real(-6.2701019733657493e-05)) * y + real(2.2702345051903161e-05);
  s = (y * s + real(3.2840291584830539e-04)) * y + real(-9.1278950740284956e-04);
  s = (y * s + real(4.1458210673776634e-04)) * y + real(3.4477792809101092e-03);
  s = (y * s + real(-9.6515712106362240e-03)) * y + real(7.9646553318685888e-03);
  s = (y * s + real(1.6315795550201557e-02)) * y + real(-5.9190340091560566e-02);
  s = (y * s + real(8.0092162593593019e-02)) * y + real(-3.0370512370362556e-02);
  s = (y * s + real(-8.5985466779947454e-02)) * y + real(2.0374146732312121e-01);
  s = (y * s + real(-2.6635652969987751e-01)) * y + real(1.2532713059402959e+00);
#else  // degree 12, 3.2e-08
  real s = real(-7.27093133e-04);
  s = (((y * s + real(1.10601875e-03)) * y + real(3.15177210e-03))
      * y + real(-1.03670707e-02)) * y + real(8.17877316e-03);
  s = (((y * s + real(1.67019115e-02)) * y + real(-5.92676500e-02))
      * y + real(7.99869288e-02)) * y + real(-3.03573807e-02);
  s = (((y * s + real(-8.59729173e-02)) * y + real(2.03740636e-01))
      * y + real(-2.66356963e-01)) * y + real(1.25327131e+00);
#endif
  return s;
}

real dawson_far(real y) {  // 2 p^2 N from 4 on, y = 32/p^2 - 1
#if REAL_BITS == 64  // degree 22, relative error 2.1e-14
  real s = real(1.2413387651122321e-08);
  s = (y * s + real(1.0979592435234053e-07)) * y + real(-7.8674615711094020e-08);
  s = (y * s + real(-7.4666749250162923e-07)) * y + real(1.9275692375586573e-07);
  s = (y * s + real(2.3768986200378706e-06)) * y + real(-8.5810160616039965e-08);
  s = (y * s + real(-4.8032193343400253e-06)) * y + real(-9.7313208932692241e-07);
  s = (y * s + real(6.9016690680059889e-06)) * y + real(4.1266478129908801e-06);
  s = (y * s + real(-6.2497282585496569e-06)) * y + real(-9.3861915518591264e-06);
  s = (y * s + real(-2.3758776970053425e-06)) * y + real(6.9189643194635456e-06);
  s = (y * s + real(1.4205389758367173e-05)) * y + real(2.3834980456337567e-05);
  s = (y * s + real(5.2556879303322093e-05)) * y + real(1.6989679448038997e-04);
  s = (y * s + real(7.9108601030996111e-04)) * y + real(5.3434339823481609e-03);
  s = (y * s + real(5.5691097058468348e-02)) * y + real(1.0510062654773443e+00);
#else  // degree 7, 5.2e-08
  real s = real(2.80396334e-06);
  s = (((y * s + real(2.18504068e-05)) * y + real(6.14675614e-05))
      * y + real(1.73538417e-04)) * y + real(7.88625889e-04);
  s = ((y * s + real(5.34251166e-03)) * y + real(5.56912795e-02)) * y + real(1.05100630e+00);
#endif
  return s;
}

Tail falling_tail(real x, real w) {
  if (x < real(2.0) * w) {
    real p = x / w;
    real f = dawson_near(real(0.5) * p * p - real(1.0));  // F/p
    return Tail(real(2.0) * p * f / w, (real(4.0) * p * p * f - real(2.0)) / (w * w));
  }
  real q = w / x;  // 1/p
  real n = x < real(4.0) * w ? dawson_middle(x / w - real(3.0))
                             : dawson_far(real(32.0) * q * q - real(1.0));
  return Tail((real(1.0) + real(0.5) * q * q * n) / x, n / x / x);
}

// The integrals over a segment of linear attenuation, without cancellation: with
// g(u) = x_f u + (x_b - x_f) u^2/2,
struct LinearPsi {
  real psi;   // Psi = integral of e^{-g} over [0, 1]
  real m;     // M = integral of u e^{-g}
  real rest;  // Psi - M
  real back;  // Psi - zeta
};

// Both ends below 1: J_k = integral of u^k e^{-g} by parts, downwards,
//   (k + 1) J_k = zeta + x_f J_{k+1} + (x_b - x_f) J_{k+2}.
// It begins with J_k = zeta/(k + 1 - x_b), off by a few 1/k^2 of itself; J_1 keeps 1/(3 5 7 ... k - 1)
// of that at most (x_f = 0): 1e-8 in float32, 1e-17 in double. Psi - zeta = x_f (J_1 - J_2) + x_b J_2.
LinearPsi thin_psi(real x_f, real x_b, real zeta) {
  real d = x_b - x_f;
#if REAL_BITS == 64
  real even = zeta / (real(27.0) - x_b);
  real odd = zeta / (real(26.0) - x_b);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 25.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 24.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 23.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 22.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 21.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 20.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 19.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 18.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 17.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 16.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 15.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 14.0);
#else
  real even = zeta / (real(15.0) - x_b);
  real odd = zeta / (real(14.0) - x_b);
#endif
  even = (zeta + x_f * odd + d * even) * real(1.0 / 13.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 12.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 11.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 10.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 9.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 8.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 7.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 6.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 5.0);
  odd = (zeta + x_f * even + d * odd) * real(1.0 / 4.0);
  even = (zeta + x_f * odd + d * even) * real(1.0 / 3.0);
  odd = (zeta + x_f * even + d * odd) * real(0.5);
  real psi = zeta + x_f * odd + d * even;
  return LinearPsi(psi, odd, psi - odd, x_f * (odd - even) + x_b * even);
}

// Else the tail from the front minus the tail from the back, behind the transparency zeta:
//   Psi = V_f - zeta V_b,  M = U_f - zeta (U_b + V_b)
// (scaled erfc where attenuation grows, Dawson's integral where it falls: Williams, Max and Stein
// 1998). Neither difference loses more than a factor 10 where an end is 1 or more.
LinearPsi linear_psi(real x_f, real x_b, real zeta) {
  LinearPsi p;
  if (max(x_f, x_b) < real(1.0)) {
    p = thin_psi(x_f, x_b, zeta);
  } else {
    real w = sqrt(real(2.0) * abs(x_b - x_f));
    bool grows = x_b >= x_f;
    Tail front = grows ? growing_tail(x_f, w) : falling_tail(x_f, w);
    Tail back = grows ? growing_tail(x_b, w) : falling_tail(x_b, w);
    real psi = front.v - zeta * back.v;
    real m = front.u - zeta * (back.u + back.v);
    p = LinearPsi(psi, m, psi - m, psi - zeta);
  }
  return p;
}
