#pragma once

#include <cstdint>
#include <string>

namespace psivox {

/// Throws Error(memory) if that many bytes are more than there are, or more than limit_claims()
/// allows. Who makes what a file asks for calls it first, so that a small file takes no memory that
/// it has not. `what` begins the message.
void claim_memory(double bytes, const std::string& what);

/// The limit of the scene that was opened last [bytes]; 0: none.
void limit_claims(std::uint64_t bytes);

}  // namespace psivox
