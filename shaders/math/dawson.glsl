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
