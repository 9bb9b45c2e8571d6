#pragma once
#include <cstdlib>
inline double tune(const char* k, double d) { const char* e = std::getenv(k); return e ? std::atof(e) : d; }
#define TUNE(name, d) ([]{ static const double v = tune(#name, d); return v; }())
