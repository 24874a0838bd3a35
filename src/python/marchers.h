#pragma once

#include <unistd.h>

#include <memory>
#include <mutex>
#include <vector>

#include "psivox/draw.h"

namespace psivox::python {

/// Marchers that nobody draws with now: opening one takes longer than drawing a small picture.
class Marchers {
 public:
  std::shared_ptr<Marcher> take(RendererKind renderer, int device);
  /// Keeps the marcher for the next picture, unless there are some already.
  void give_back(RendererKind renderer, int device, std::shared_ptr<Marcher> marcher);
  void close();

 private:
  struct Idle {
    RendererKind renderer;
    int device;
    std::shared_ptr<Marcher> marcher;
  };
  std::mutex mutex_;
  std::vector<Idle> idle_;
};

/// Never destroyed: drivers end before a static object would.
Marchers& marchers();

/// A marcher while somebody draws with it.
class Lease {
 public:
  Lease() = default;
  ~Lease() { end(); }
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;

  /// The marcher that a scene asks for.
  Marcher& get(const Scene& scene);
  /// Gives the marcher back; `large`: what it holds takes so much memory that it is closed.
  void end(bool large = false);

 private:
  RendererKind renderer_ = RendererKind::gl;
  int device_ = -1;
  std::shared_ptr<Marcher> marcher_;
};

/// Throws Error(failure) in a process that was forked from one that has drawn: neither threads nor
/// OpenGL survive a fork.
void check_process();

}  // namespace psivox::python
