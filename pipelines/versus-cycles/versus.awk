# Errors of our picture and of Cycles's, from six channels a pixel as `oiiotool --dumpdata` prints them: ours D, two by Cycles
# C1 and C2 of different seeds, alpha, the measured error E of the pixel's block of 8x8 pixels (D less light paths) and its
# standard error V. Prints a row of versus.csv for each size of blocks. Errors are relative to the mean by light paths, over
# pixels that a certificate counts: those that see the cloud, and their neighbours (docs/certificate.md).
#
# Mean squares over blocks, of means of the pixels that count in a block; weights are the numbers of these pixels:
#
#   noise of Cycles        (C1 - C2)^2 / 2, from blocks of 8x8 pixels, which are independent of each other
#   bias of Cycles         (C1 - P)(C2 - P) - V^2, P = D - E: the noises are independent, so the mean is the bias alone
#   difference             (D - C1)(D - C2)
#
# Intervals are two standard deviations of the mean over blocks to each side. Cycles's noise falls as 1 / samples: its seconds at
# our error e are seconds noise^2 / (e^2 - bias^2), where the bias counts if its interval does not reach 0. Where the bias exceeds
# e, no number of samples reaches e ("never"). Seconds count as proportional to samples; the preparation of the scene, 0.4 s at
# 256x256 pixels, is a part of them.
/^ *Pixel/ {
    gsub(/[(),:]/, " ")
    d[$2, $3] = $4; c1[$2, $3] = $5; c2[$2, $3] = $6; alpha[$2, $3] = $7; e[$2, $3] = $8; v[$2, $3] = $9
}
function counts(x, y,    i, j) {
    for (i = -1; i <= 1; ++i)
        for (j = -1; j <= 1; ++j)
            if (alpha[x + i, y + j] > 0 || d[x + i, y + j] > 0) return 1
    return 0
}
function root(x) { return x > 0 ? sqrt(x) : 0 }
# at_equal ERROR: seconds of Cycles.
function at_equal(error) { return error <= bias ? "never" : sprintf("%.4g", cycles_seconds * noise / (error ^ 2 - bias ^ 2)) }
# row EDGE "VALUE LOW HIGH": of the chain's error over blocks, with sums over their pixels: W[] of 1, SD[] of D, S1[] of C1,
# S2[] of C2, SE[] of E; N[] and SV[] are the variances of the sums of C1 and of the light paths.
function row(edge, rms,    b, k, p, q, square, spread, error) {
    noise = 0
    for (b in W) {  # q[b, 1], square[1]: bias; q[b, 2], square[2]: difference
        p = (SD[b] - SE[b]) / W[b]
        q[b, 1] = (S1[b] / W[b] - p) * (S2[b] / W[b] - p) - SV[b] / W[b] ^ 2
        q[b, 2] = (SD[b] - S1[b]) / W[b] * (SD[b] - S2[b]) / W[b]
        for (k = 1; k <= 2; ++k) square[k] += W[b] / total * q[b, k]
        noise += W[b] / total * N[b] / W[b] ^ 2 / paths ^ 2
    }
    for (k = 1; k <= 2; ++k) {
        for (b in W) spread[k] += (W[b] / total * (q[b, k] - square[k])) ^ 2
        spread[k] = 2 * sqrt(spread[k]) / paths ^ 2
        square[k] /= paths ^ 2
    }
    bias = (square[1] > spread[1]) ? sqrt(square[1]) : 0
    split(rms, error, " ")
    printf "%s,%d,%s,%d,%d,%s,", g, edge, blender, voxels, pixels, albedo
    printf "%.6g,%.6g,%.6g,%.3g,%.3g,", mean_d, mean_c, paths, noise_of_mean / mean_c, (mean_error[3] - mean_error[2]) / 2
    printf "%.6g,%.4g,%.4g,%.4g,%s,", seconds, error[1], error[2], error[3], reliable
    printf "%d,%.4g,%.4g,", samples, cycles_seconds, sqrt(noise)
    for (k = 1; k <= 2; ++k)
        printf "%.4g,%.4g,%.4g,", root(square[k]), root(square[k] - spread[k]), root((square[k] > 0 ? square[k] : 0) + spread[k])
    printf "%s,%s,%s,%d,%.4g\n", at_equal(error[1]), at_equal(error[3]), at_equal(error[2]), few, few_seconds
}
END {
    split(mean, mean_error, " ")
    for (y = 0; y < pixels; ++y)
        for (x = 0; x < pixels; ++x) {
            if (!counts(x, y)) continue
            b = int(x / 8) " " int(y / 8)
            ++W[b]; SD[b] += d[x, y]; S1[b] += c1[x, y]; S2[b] += c2[x, y]; SE[b] += e[x, y]; V[b] = v[x, y]
        }
    for (b in W) {
        total += W[b]; mean_d += SD[b]; mean_c += (S1[b] + S2[b]) / 2
        N[b] = (S1[b] - S2[b]) ^ 2 / 2
        SV[b] = (W[b] * V[b]) ^ 2
        noise_of_mean += N[b] / 2
    }
    mean_d /= total; mean_c /= total
    noise_of_mean = 1.96 * sqrt(noise_of_mean) / total
    printf "g,block,blender,voxels,pixels,albedo,chain_mean,cycles_mean,paths_mean,cycles_mean_half_width,paths_mean_half_width,"
    printf "chain_seconds,chain_error,chain_error_low,chain_error_high,reliable,samples,cycles_seconds,cycles_noise,"
    printf "cycles_bias,cycles_bias_low,cycles_bias_high,difference,difference_low,difference_high,"
    print "seconds_at_equal_error,seconds_at_equal_error_low,seconds_at_equal_error_high,few_samples,few_seconds"
    row(8, rms8)
    for (b in W) {
        split(b, place, " ")
        k = int(place[1] / 4) " " int(place[2] / 4)
        w[k] += W[b]; sd[k] += SD[b]; s1[k] += S1[b]; s2[k] += S2[b]; se[k] += SE[b]; sv[k] += SV[b]; n[k] += N[b]
    }
    split("", W)
    for (k in w) {
        ++blocks
        W[k] = w[k]; SD[k] = sd[k]; S1[k] = s1[k]; S2[k] = s2[k]; SE[k] = se[k]; SV[k] = sv[k]; N[k] = n[k]
    }
    if (blocks >= 12) row(32, rms32)
}
