#pragma once

namespace kerf {

// Elementary functions whose results have the same bits on every processor. Those of the C library do not: it picks
// variants with fused multiply-add at run time, whose last bits differ. All that a sheet's state, mesh or cuts depend
// on takes these. Addition, multiplication, division, std::sqrt, std::fma, std::fmod and std::ldexp are exact or
// correctly rounded everywhere and need no substitute; std::hypot has no variants.
//
// Errors are below 0.6 units in the last place (those of `power`: 0.75), and below 1 where the result is subnormal.
// Special values are those of the C standard.

// Sine and cosine of an angle of any size, rad. NaN for an infinite angle.
double sine(double angle);
double cosine(double angle);
// Returns the angle (rad) of the point (x, y), from -pi to pi, as std::atan2 does.
double arc_tangent(double y, double x);
// Returns the angle (rad) from 0 to pi that has this cosine; NaN outside [-1, 1].
double arc_cosine(double cosine);
double exponential(double x);
// Returns the natural logarithm; minus infinity for 0, NaN for negative x.
double logarithm(double x);
// Returns the logarithm to base 10, with the same special values.
double decimal_logarithm(double x);
// Returns x to the power of y; NaN for x < 0 unless y is a whole number.
double power(double x, double y);

}  // namespace kerf
