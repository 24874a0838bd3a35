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
