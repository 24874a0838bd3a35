#pragma once

#include <cstdint>
#include <string>

#include "psivox/draw.h"
#include "psivox/error.h"

// Pages: a picture that turns in a browser with WebGL 2, as one file that needs no network.

namespace psivox {

struct PageOptions {
  std::string credit;    ///< a line below the picture; empty: none
  double limit_mb = 32;  ///< largest size of the page [10^6 bytes]
};

/// Whether the name ends in .html or .htm.
bool is_page_name(const std::string& path);

/// Why no page shows the scene, in one line; empty if one does.
std::string page_obstacle(const Scene& scene);

/// Throws what write_page would throw, as far as that is known before the picture is drawn.
void check_page(Session& session, const PageOptions& options);

/// Writes the page of a picture that the session has drawn: the march's shaders for WebGL 2, the
/// atlas with its light, and the picture itself for browsers that cannot draw. Returns the page's
/// bytes. Throws Error(usage) if the page is larger than the limit or cannot show the scene,
/// Error(memory) if the volume was drawn in parts, Error(output).
std::uint64_t write_page(const std::string& path, Session& session, const Drawn& drawn,
                         const PageOptions& options);

}  // namespace psivox
