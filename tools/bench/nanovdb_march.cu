// nanovdb_march on a CUDA device: a thread a pixel, warps of 8x4 pixels. compare_gpu.py builds it
// with nvcc and runs it.
//
//   nanovdb_march_cuda FILE.nvdb OUT.exr step=1 size=512 ...    (nanovdb_march.cpp writes FILE.nvdb)
//
// It prints {"march_ms": ..}, the least of nine marches by the device's events, after one that is not
// counted.

#include <nanovdb/util/IO.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <vector>

#include "nanovdb_loop.h"
#include "psivox/image.h"

namespace {

using namespace nanovdb_loop;

void check(cudaError_t result) {
  if (result != cudaSuccess) throw std::runtime_error(cudaGetErrorString(result));
}

__global__ void march(const Grid* grid, Frame frame, Medium medium, float* rgba) {
  const int x = int(blockIdx.x * blockDim.x + threadIdx.x);
  const int y = int(blockIdx.y * blockDim.y + threadIdx.y);
  if (x >= frame.size || y >= frame.size) return;
  const auto values = grid->tree().getAccessor(), leaves = grid->tree().getAccessor();
  draw_pixel(frame, x, y, *grid, medium, values, leaves, rgba);
}

/// Memory of the device.
template <class T>
class Buffer {
 public:
  explicit Buffer(std::size_t bytes) { check(cudaMalloc(&data_, bytes)); }
  ~Buffer() { cudaFree(data_); }
  Buffer(const Buffer&) = delete;
  T* get() const { return data_; }

 private:
  T* data_ = nullptr;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) throw std::runtime_error("nanovdb_march_cuda FILE.nvdb OUT.exr NAME=VALUE ...");
  const Options options(argc, argv);
  const auto handle = nanovdb::io::readGrid(argv[1]);
  const Buffer<Grid> grid(handle.size());
  check(cudaMemcpy(grid.get(), handle.data(), handle.size(), cudaMemcpyHostToDevice));
  const Frame frame(options);
  const Medium medium(options, handle.grid<float>()->voxelSize()[0]);
  psivox::Image image = picture_of(frame.size);
  std::vector<float>& values = image.layers[0].values;
  const Buffer<float> rgba(values.size() * sizeof(float));

  const dim3 block(8, 16), blocks((frame.size + 7) / 8, (frame.size + 15) / 16);
  cudaEvent_t begin, end;
  check(cudaEventCreate(&begin));
  check(cudaEventCreate(&end));
  float least = std::numeric_limits<float>::infinity();
  for (int run = 0; run < 10; ++run) {
    float ms = 0;
    check(cudaEventRecord(begin));
    march<<<blocks, block>>>(grid.get(), frame, medium, rgba.get());
    check(cudaEventRecord(end));
    check(cudaEventSynchronize(end));
    check(cudaEventElapsedTime(&ms, begin, end));
    if (run > 0) least = std::min(least, ms);
  }
  check(cudaMemcpy(values.data(), rgba.get(), values.size() * sizeof(float),
                   cudaMemcpyDeviceToHost));
  std::printf("{\"march_ms\": %.4f}\n", least);
  psivox::write_image(image, argv[2]);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "nanovdb_march_cuda: %s\n", error.what());
  return 1;
}
