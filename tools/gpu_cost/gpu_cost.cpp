// gpu_cost [--assets DIR] [--check]: what psivox's programs cost on GPUs, without one: RADV
// compiles them for AMD's. Prints a table of listed programs. --check prints nothing but faults: a
// program that glslang refuses, spills, or registers far above the list's.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <sstream>

#include "base/stopwatch.h"
#include "programs.h"
#include "psivox/parameters.h"

namespace {

using namespace psivox;
using namespace psivox::gpu_cost;

constexpr int skipped = 77;        // ctest's code for a test that cannot run here
constexpr int more_registers = 8;  // than the list's are allowed: one granule of the hardware's
const char* const families[] = {"navi21", "gfx1100"};

/// Instructions that a wave executes in one turn of the march's loop if it skips none.
struct TurnCost {
  int instructions = 0;  ///< of all kinds
  int vector = 0;        ///< arithmetic of all lanes
  int quarter = 0;       ///< part of `vector` that runs at a quarter of the rate
  int fetches = 0;       ///< of texels, page table entries and tables

  /// Clocks that a SIMD lane computes.
  int lane_clocks() const { return vector + 3 * quarter; }
};

/// Instructions from the first to before the last.
struct Stretch {
  std::size_t first = 0, last = 0;
  std::size_t size() const { return last - first; }
};

/// A program's instructions by name, and the loops among them.
struct Listing {
  std::vector<std::string> names;
  std::vector<Stretch> loops;  ///< each from its first label to the last jump to it
};

Listing read(const std::string& assembly) {
  Listing listing;
  std::map<std::string, std::size_t> labels;
  std::map<std::size_t, std::size_t> ends;  ///< of loops, by their first instruction
  std::istringstream lines(assembly);
  std::string line;
  while (std::getline(lines, line)) {
    if (line.starts_with("BB")) {
      labels[line.substr(0, line.find(':'))] = listing.names.size();
      continue;
    }
    std::istringstream words(line);
    std::string name, target;
    if (!(words >> name) || name.starts_with(";")) continue;
    words >> target;
    listing.names.push_back(name);
    const auto label = labels.find(target);
    if (label != labels.end() && (name.starts_with("s_branch") || name.starts_with("s_cbranch")))
      ends[label->second] = listing.names.size();
  }
  for (const auto& [first, last] : ends) listing.loops.push_back({first, last});
  return listing;
}

/// The longest loop inside a stretch, apart from that itself; empty: there is none.
Stretch longest_in(const Listing& listing, const Stretch& outer) {
  Stretch longest;
  for (const Stretch& loop : listing.loops)
    if (loop.first >= outer.first && loop.last <= outer.last && loop.size() < outer.size() &&
        loop.size() > longest.size())
      longest = loop;
  return longest;
}

bool starts_with_any(const std::string& name, std::initializer_list<const char*> prefixes) {
  return std::ranges::any_of(prefixes, [&](auto* prefix) { return name.starts_with(prefix); });
}

/// Reads the turn off a program's assembly, as LLVM prints it. The march is a loop around a loop of
/// 16 turns, and the turn is the body of the inner one; where the outermost loop holds none that is
/// as long as half of it, the turn is its own body. All 0 of a program without loops.
TurnCost turn_cost(const std::string& assembly) {
  const Listing listing = read(assembly);
  Stretch turn = longest_in(listing, {0, listing.names.size() + 1});
  if (const Stretch inner = longest_in(listing, turn); 2 * inner.size() > turn.size()) turn = inner;
  TurnCost cost;
  for (std::size_t i = turn.first; i < turn.last; ++i) {
    const std::string& name = listing.names[i];
    ++cost.instructions;
    if (name.starts_with("v_")) ++cost.vector;
    if (starts_with_any(name, {"v_rcp", "v_rsq", "v_sqrt", "v_exp", "v_log", "v_mul_lo", "v_mul_hi",
                               "v_mad_u64"}))
      ++cost.quarter;
    if (starts_with_any(name, {"buffer_load", "tbuffer_load", "image_"})) ++cost.fetches;
  }
  return cost;
}

// --- programs

Scene scene_of(const Listed& program, const std::filesystem::path& assets) {
  Scene scene = scene_from_json("{" + program.scene + "}");
  scene.input = (assets / "blobs.vdb").string();
  if (!scene.transfer_function.empty())
    scene.transfer_function = (assets / scene.transfer_function).string();
  scene.resolution = {64, 64};
  return scene;
}

/// The listed program, found among the programs of its scene.
Program find_program(const Listed& listed, const std::filesystem::path& assets) {
  for (Program& program : programs_of(scene_of(listed, assets)))
    if (program.shader == listed.shader) return program;
  throw std::runtime_error("'" + listed.name + "' needs no " + listed.shader);
}

Module fragment_of(const std::string& text, bool optimised = true) {
  return module_from_glsl(text, vk::ShaderStageFlagBits::eFragment, optimised);
}

void print_row(const Listed& listed, const std::string& text, const NullDevice& device) {
  const Compiled c = device.compile(fragment_of(text));
  const TurnCost turn = turn_cost(c.assembly);
  const Module unchanged = fragment_of(text, false);
  const Stopwatch building;
  const Compiled plain = device.compile(unchanged);
  std::printf("| %s | %d | %d | %d | %d | %d | %d | %d | %d | %d | %d | %.0f |\n",
              listed.name.c_str(), c.registers, c.spills, c.waves, c.instructions, c.branches,
              c.inverse_throughput, turn.instructions, turn.lane_clocks(), turn.fetches,
              plain.registers, building.cpu_ms());
}

void print_table(const std::filesystem::path& assets) {
  std::vector<std::string> texts;
  for (const Listed& listed : listed_programs()) texts.push_back(find_program(listed, assets).text);
  for (const char* family : families) {
    const NullDevice device(family);
    std::printf(
        "\n%s\n\n| program | VGPRs | spills | waves per SIMD | instructions | branches | inverse "
        "throughput | a turn: instructions | arithmetic | fetches | plain: VGPRs | build [ms] |\n"
        "|---|---|---|---|---|---|---|---|---|---|---|---|\n",
        family);
    for (std::size_t i = 0; i < texts.size(); ++i)
      print_row(listed_programs()[i], texts[i], device);
  }
}

/// Prints the faults of the listed programs; returns their number.
int check_programs(const NullDevice& device, const std::filesystem::path& assets) {
  int faults = 0;
  for (const Listed& listed : listed_programs()) {
    std::string fault;
    try {
      const Compiled c = device.compile(fragment_of(find_program(listed, assets).text));
      if (c.spills) fault = std::to_string(c.spills) + " registers are spilled";
      if (c.registers > listed.registers + more_registers)
        fault = std::to_string(c.registers) + " registers, " + std::to_string(listed.registers) +
                " were enough before";
    } catch (const std::runtime_error& error) {
      fault = error.what();
    }
    if (fault.empty()) continue;
    std::printf("%s: %s\n", listed.name.c_str(), fault.c_str());
    ++faults;
  }
  return faults;
}

int check_all(const std::filesystem::path& assets) {
  std::optional<NullDevice> device;
  try {
    device.emplace(families[0]);
  } catch (const std::runtime_error& error) {
    std::printf("skipped: %s\n", error.what());
    return skipped;
  }
  return check_programs(*device, assets) ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::string assets = "assets";
  bool check = false;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--check") {
      check = true;
    } else if (argument == "--assets" && i + 1 < argc) {
      assets = argv[++i];
    } else {
      std::fprintf(stderr, "usage: gpu_cost [--assets DIR] [--check]\n");
      return 2;
    }
  }
  try {
    if (check) return check_all(assets);
    print_table(assets);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "gpu_cost: %s\n", error.what());
    return 1;
  }
  return 0;
}
