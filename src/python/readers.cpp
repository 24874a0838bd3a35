// The program whose processes read .vdb files for Python.

#include "base/guarded_reading.h"

int main() { psivox::serve_guarded_reading(); }
