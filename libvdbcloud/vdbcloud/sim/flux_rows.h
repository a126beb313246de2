#pragma once
// Tendencies of a conservation law, row by row: each flux is computed once and used on both of its sides. Private to
// sim/.
#include "vdbcloud/sim/parallel.h"
#include "vdbcloud/sim/rows.h"

#include <vector>

namespace vdbcloud::sim {

/// The control volumes of one transported quantity: rows j in [0, rows), planes k in [first, last), `width` of them a
/// row; axes that are flat have no fluxes.
struct ControlVolumes {
    int width, rows, first, last;
    bool x, y, z;
};

/// Calls sink(j, k, tendency, rows) for each row, where tendency is minus the divergence of the fluxes that
/// flux(axis, j, k, out, n) fills: those through the lower faces of row (j, k), n = width + 1 for axis 0.
/// coefficients(k, rows) sets the 1 / spacing of `rows`. Tiles of planes and rows that fit in cache run in parallel.
/// Each recomputes the fluxes on its lower edges, with equal values.
template<typename T, typename Coefficients, typename Flux, typename Sink>
void for_flux_rows(const ControlVolumes& box, const Coefficients& coefficients, const Flux& flux, const Sink& sink)
{
    const int planes = box.last - box.first;
    const int deep = std::max(4, planes / 8), tall = std::max(8, std::min(box.rows, 32));
    const int tiles_k = (planes + deep - 1) / deep, tiles_j = (box.rows + tall - 1) / tall;
    const size_t width = size_t(box.width);
    for_chunks(tiles_k * tiles_j, 1, [&](int tile, int) {
        const int k0 = box.first + tile / tiles_j * deep, k1 = std::min(box.last, k0 + deep);
        const int j0 = tile % tiles_j * tall, j1 = std::min(box.rows, j0 + tall);
        std::vector<T> below(box.z ? width * size_t(j1 - j0) : 0), above(below.size()), fx(width + 1), south(width),
            north(width);
        std::vector<T> tendency(width);
        if (box.z)
            for (int j = j0; j < j1; ++j) flux(2, j, k0, &below[size_t(j - j0) * width], box.width);
        for (int k = k0; k < k1; ++k) {
            FluxRows<T> rows{};
            coefficients(k, rows);
            if (box.y) flux(1, j0, k, south.data(), box.width);
            for (int j = j0; j < j1; ++j) {
                if (box.x) flux(0, j, k, fx.data(), box.width + 1), rows.x = fx.data();
                if (box.y) flux(1, j + 1, k, north.data(), box.width), rows.y0 = south.data(), rows.y1 = north.data();
                if (box.z) {
                    const size_t row = size_t(j - j0) * width;
                    flux(2, j, k + 1, &above[row], box.width);
                    rows.z0 = &below[row], rows.z1 = &above[row];
                }
                flux_tendency(rows, tendency.data(), box.width);
                sink(j, k, tendency.data(), rows);
                south.swap(north);
            }
            below.swap(above);
        }
    });
}

}  // namespace vdbcloud::sim
