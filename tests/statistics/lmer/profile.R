# The values in profile.json, from lme4's restricted likelihood (devFunOnly): Rscript profile.R *.csv > profile.json
# lme4's own profile() and confint() refit by unrestricted maximum likelihood; their limits are other numbers.
suppressMessages(library(lme4))
number <- function(x) paste0("[", paste(formatC(x, digits = 15, format = "g"), collapse = ", "), "]")
least <- function(f, start) { # bounded below by 0, from several starts, to the last digits
  if (length(start) == 1) {
    tries <- lapply(c(1, 3, 10), function(most) optimize(function(x) f(abs(x)), c(0, most), tol = 1e-12)$objective)
    return(min(unlist(tries), f(0)))
  }
  best <- Inf
  for (scale in c(0.3, 1, 3)) {
    found <- start * scale
    for (i in 1:4) found <- nlminb(found, f, lower = 0, control = list(rel.tol = 1e-15, x.tol = 1e-12, eval.max = 2000, iter.max = 2000))$par
    best <- min(best, f(found))
  }
  best
}
studies <- sapply(commandArgs(TRUE), function(file) {
  d <- read.csv(file, stringsAsFactors = TRUE)
  f <- lmer(b ~ specimen + (1 | participant) + (1 | participant:specimen), d, devFunOnly = TRUE)
  e <- environment(f); free <- nrow(d) - nlevels(d$specimen)
  # -2 log restricted likelihood at SDs (person, cell, repetition); lme4's theta is (cell, person) / repetition
  full <- function(sd) {
    f(c(sd[2], sd[1]) / sd[3])
    squares <- e$resp$wrss() + e$pp$sqrL(1)
    e$pp$ldL2() + e$pp$ldRX2() + free * log(2 * pi * sd[3]^2) + squares / sd[3]^2
  }
  ratio <- function(r) f(c(r[2], r[1]))
  control <- lmerControl(optimizer = "bobyqa", optCtrl = list(rhoend = 1e-11, maxfun = 1e5), check.conv.singular = "ignore")
  m <- lmer(b ~ specimen + (1 | participant) + (1 | participant:specimen), d, control = control)
  v <- as.data.frame(VarCorr(m)); at <- v$sdcor[match(c("participant", "participant:specimen", "Residual"), v$grp)]
  limits <- function(cost, best, i, lowest) {
    others <- best[-i]
    excess <- function(x) least(function(o) { p <- best; p[i] <- x; p[-i] <- abs(o); if (length(best) == 3 && p[3] < 1e-3) return(1e6); cost(p) },
                                pmax(others, 0.05)) - lowest - qchisq(0.95, 1)
    least_x <- if (length(best) == 3 && i == 3) 0.3 * best[3] else 0
    low <- if (best[i] < 1e-6 || excess(least_x) <= 0) 0 else uniroot(excess, c(least_x, best[i]), tol = 1e-11)$root
    c(low, uniroot(excess, c(max(best[i], 1e-3), 5 * max(best[i], 1)), tol = 1e-11)$root)
  }
  lowest <- REMLcrit(m)
  sds <- sapply(1:3, function(i) limits(full, at, i, lowest))
  ratios <- sapply(1:2, function(i) limits(ratio, at[1:2] / at[3], i, lowest))
  rows <- order(d$participant, d$specimen)
  sprintf('  "%s": {\n    "sd_low": %s,\n    "sd_high": %s,\n    "ratio_low": %s,\n    "ratio_high": %s,\n    "fitted": %s\n  }', file,
    number(sds[1, ]), number(sds[2, ]), number(ratios[1, ]), number(ratios[2, ]), number(fitted(m)[rows]))
})
cat("{\n", paste(studies, collapse = ",\n"), "\n}\n", sep = "")
