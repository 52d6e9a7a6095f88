#pragma once

#include <string>
#include <vector>

#include "weft/devices.hpp"
#include "weft/exec/machine_probe.hpp"
#include "weft/scene.hpp"

namespace weft {

/// What the model of a product's time knows of a scene's linear system. A product is one iteration
/// of conjugate gradients: the product itself, vectors and preconditioner.
struct ProductLoad {
  double rows = 0;                             ///< 3 x 3 blocks
  double bytes_a_row = 0;                      ///< that an iteration reads and writes
  double vector_bytes = 0;                     ///< of one row of a vector
  bool contacts = false;                       ///< rows may ask for rows anywhere
  Transport transport = Transport::automatic;  ///< that the scene asks for
};

/// @param scene valid
ProductLoad product_load(const Scene& scene);

/// Rows of others that a rank of `ranks` needs, if each has as many: what surrounds a compact piece
/// of a sheet, two vertices wide, and with contacts as many as half of the own ones.
double halo_rows(const ProductLoad& load, int ranks);

/// Time of an iteration on `ranks` GPUs. [s]
/// With `peer` the halo comes first, then the product: P-Cloth eq. (6) with the halo for the
/// sub-vectors. With `pipelined` whole sub-vectors come one after the other, by the work queues,
/// while rows are multiplied that need none of those still to come: eq. (7); but no faster than one
/// thread issues all of it.
/// @param bandwidth [B/s] of the slowest GPU
/// @param link      the slowest of those between these GPUs; not used by one GPU
/// @param transport peer or pipelined
double product_time(const ProductLoad& load, double bandwidth, int ranks, const LinkFigures& link,
                    Transport transport);

/// Time of a step with a typical number of iterations and typical contacts. What matters is how it
/// changes with the number of GPUs: that was fitted to three drapes on one and two H200s and is
/// within 20 % of what others take (test DeviceChoice.ModelMeetsMeasuredSteps). Parameters as of
/// product_time(). [s]
double step_time(const ProductLoad& load, double bandwidth, int ranks, const LinkFigures& link,
                 Transport transport);

/// What `auto` stands for. CPU: where there is no GPU, or the method runs there alone. Else as
/// many GPUs as pay: 1, 2, 4, ... and all of them, as long as step_time() falls by an eighth each
/// time. GPUs that cannot pay are not measured.
/// @param scene valid
/// @throws DeviceError if a GPU cannot be measured
DeviceChoice choose_devices(const Scene& scene, MachineProbe& probe);

/// As choose_devices(), but where a GPU cannot be measured the choice names no device, and its
/// reason is what failed.
/// @param scene valid
DeviceChoice look_for_devices(const Scene& scene, MachineProbe& probe);

/// One line a link between two of the machine's GPUs, for people.
/// @throws DeviceError if a GPU cannot be measured
std::vector<std::string> describe_links(MachineProbe& probe);

}  // namespace weft
