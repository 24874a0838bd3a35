#pragma once

#include <string>

#include "psivox/draw.h"
#include "psivox/error.h"

// Pages: a picture that turns in a browser with WebGL 2, as one file that needs no network.

namespace psivox {

struct PageOptions {
  std::string credit{};  ///< a line below the picture; empty: none
  double limit_mb = 32;  ///< largest size of the page [10^6 bytes]
};

/// Whether the name ends in .html or .htm.
bool is_page_name(const std::string& path);

/// Why no page shows the scene, in one line; empty if one does.
std::string page_obstacle(const Scene& scene);

/// Throws what page_text would throw of a scene, as far as that is known before it is drawn.
void check_page(Session& session, const Scene& scene, const PageOptions& options);

/// The page of a picture that the session has drawn: the march's shaders for WebGL 2, the atlas
/// with its light, and the picture itself for browsers that cannot draw. Throws Error(usage) if the
/// page is larger than the limit, Error(memory) if the volume was drawn in parts.
std::string page_text(Session& session, const Drawn& drawn, const PageOptions& options);

}  // namespace psivox
