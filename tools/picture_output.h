#pragma once

#include <map>
#include <string>
#include <vector>

#include "psivox/medium.h"
#include "render_call.h"
#include "render_report.h"

namespace psivox {

/// Whether a look's background is wanted: not where a picture may be composited as it is, nor where
/// --background is given, if only as `none`.
bool shows_background(const RenderCall& call);

/// The metadata of a picture of that scene, but for the renderer's name.
std::map<std::string, std::string> picture_metadata(const RenderCall& call,
                                                    const std::string& output, const Scene& scene);

/// Writes the report's picture with its scene, composited with the background and with the color
/// bar that the scene asks for, and completes the report. Returns sentences for the user. Throws
/// Error(output).
std::vector<std::string> write_picture(const RenderCall& call, const std::string& output,
                                       const View& view, RenderReport& report);

/// Writes the picture of `psivox render` as write_picture does, and prints what there is to say.
void put_out(const RenderCall& call, const View& view, RenderReport& report);

}  // namespace psivox
