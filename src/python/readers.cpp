// The program whose processes read .vdb files for Python.

#include "psivox/vdb.h"

int main() { psivox::serve_guarded_reading(); }
