#pragma once

#include <optional>
#include <string>

#include "host/lab/worn/body_figure.hpp"

namespace weft::lab {

enum class PanelSide { unknown, front, back };

/// Whether the words of a name say that a panel is in front or behind: front, f, ftorso; back,
/// rear, b, btorso.
PanelSide panel_side(const std::string& name);

/// Unit horizontal direction in which a body that stands looks: that of its feet. Empty: these do
/// not tell, since they do not point the same way, or not ahead.
/// @param up unit
std::optional<Vec3<double>> looking(const BodyLines& body, const Vec3<double>& up);

}  // namespace weft::lab
