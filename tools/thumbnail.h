#pragma once

#include <string>

#include "render_call.h"

namespace psivox {

/// Completes a call with --thumbnail: a small picture for a file manager, which asks for one of
/// every file that it shows. The picture is square, exact enough for 8 bits, and quiet; file,
/// memory and time are bounded. Throws Error(input) for a file beyond the bound.
void make_thumbnail(RenderCall& call, Scene& scene);

/// Gives the picture the name that was asked for: some file managers name no extension.
void name_thumbnail(const RenderCall& call);

}  // namespace psivox
