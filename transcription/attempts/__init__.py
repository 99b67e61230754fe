"""A first mesh whose solve failed, crawled or is doubtful in; another solution out, and what was done."""
