#include "vdbcloud/solve/graph.h"

#include "vdbcloud/solve/parallel.h"

#include <algorithm>

namespace vdbcloud {

double Graph::linked(size_t i) const
{
    double sum = 0;
    for (uint32_t k = begin[i]; k < begin[i + 1]; ++k) sum += c[k];
    return sum;
}

Graph joined(std::vector<Graph>& parts)
{
    if (parts.size() == 1) return std::move(parts[0]);
    Graph whole;
    size_t rows = 0, links = 0;
    for (const Graph& part : parts) {
        rows += part.size();
        links += part.links();
    }
    whole.begin.reserve(rows + 1);
    whole.extra.reserve(rows);
    whole.column.reserve(links);
    whole.c.reserve(links);
    for (Graph& part : parts) {
        const uint32_t before = uint32_t(whole.column.size());
        whole.column.insert(whole.column.end(), part.column.begin(), part.column.end());
        whole.c.insert(whole.c.end(), part.c.begin(), part.c.end());
        whole.extra.insert(whole.extra.end(), part.extra.begin(), part.extra.end());
        for (size_t i = 1; i < part.begin.size(); ++i) whole.begin.push_back(before + part.begin[i]);
        part = {};
    }
    return whole;
}

void list_members(const std::vector<int32_t>& group, size_t count, std::vector<uint32_t>& first,
                  std::vector<int32_t>& member)
{
    first.assign(count + 1, 0);
    for (int32_t g : group)
        if (g >= 0) ++first[size_t(g) + 1];
    for (size_t g = 0; g < count; ++g) first[g + 1] += first[g];
    member.resize(first[count]);
    std::vector<uint32_t> at(first.begin(), first.end() - 1);
    for (size_t i = 0; i < group.size(); ++i)
        if (group[i] >= 0) member[at[size_t(group[i])]++] = int32_t(i);
}

Graph collapsed(const Graph& fine, const std::vector<int32_t>& group, size_t count)
{
    std::vector<uint32_t> first;
    std::vector<int32_t> member;
    list_members(group, count, first, member);
    constexpr size_t part_size = 4096;
    std::vector<Graph> parts((count + part_size - 1) / part_size);
    for_each(parts.size(), [&](size_t part) {
        std::vector<int32_t> place(count, -1);  // of a column among the links of the row
        std::vector<std::pair<int32_t, double>> links;
        for (size_t g = part * part_size; g < std::min(count, (part + 1) * part_size); ++g) {
            double extra = 0;
            for (uint32_t m = first[g]; m < first[g + 1]; ++m) {
                const size_t i = size_t(member[m]);
                extra += fine.extra[i];
                for (uint32_t k = fine.begin[i]; k < fine.begin[i + 1]; ++k) {
                    const int32_t to = group[size_t(fine.column[k])];
                    if (to < 0)
                        extra += fine.c[k];
                    else if (size_t(to) != g) {
                        int32_t& at = place[size_t(to)];
                        if (at < 0) {
                            at = int32_t(links.size());
                            links.emplace_back(to, 0.0);
                        }
                        links[size_t(at)].second += fine.c[k];
                    }
                }
            }
            for (const auto& [to, sum] : links) {
                parts[part].add_link(to, sum);
                place[size_t(to)] = -1;
            }
            links.clear();
            parts[part].end_row(extra);
        }
    });
    return joined(parts);
}

}  // namespace vdbcloud
