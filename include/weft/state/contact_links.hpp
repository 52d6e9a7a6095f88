#pragma once

#include "weft/core/ids.hpp"
#include "weft/core/span.hpp"
#include "weft/core/vec.hpp"

namespace weft {

/// A contact or a spring in a product with a vector x of vertices: its pull is B d with
/// d = sum_j w[j] x[v[j]], and corner j of it adds w[j] times that to its row.
template <class T>
struct alignas(16) ContactLink {
  Index v[4];  ///< of the cloth; corners that it does not have repeat one of those it has
  T w[4];      ///< 0 at corners that it does not have
  T block[6];  ///< [kg] B, symmetric: xx, xy, xz, yy, yz, zz
};

/// What a link comes to, in as few loads as there can be.
template <class T>
struct alignas(4 * sizeof(T)) LinkPull {
  Vec3<T> x;
};

/// A corner in the row that it adds to.
template <class T>
struct alignas(2 * sizeof(T)) LinkEnd {
  Index link;
  T weight;
};

/// The contact part of a rank's rows as a product of factors. In single precision a contact of four
/// corners has sixteen entries of 40 bytes in a matrix, while a link and its pull have 80 bytes,
/// and an end 8; what moves is the same for every link, however many of them a row has.
template <class T>
struct ContactLinks {
  Span<const ContactLink<T>> link;  ///< with a corner in own rows, in the order of contacts
  Span<const Index> count;          ///< [1] links that there are; empty: none
  Span<const Index> end_offset;     ///< [rows + 1]
  Span<const LinkEnd<T>> end;       ///< row by row, in the order of links
  Span<LinkPull<T>> pull;           ///< [links] scratch of products
};

}  // namespace weft
