// The program whose processes read .vdb files for Python.

#include "psivox/guarded_reading.h"

int main() { psivox::serve_guarded_reading(); }
